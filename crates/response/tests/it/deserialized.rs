//! Settings that are read from elsewhere: checked as those that are made.

use response::{Friction, Margins, SpringDamper};
use serde::Deserialize;
use serde::de::value::{Error, MapAccessDeserializer, MapDeserializer};

fn read<'de, T: Deserialize<'de>>(fields: [(&'static str, f64); 2]) -> Result<T, Error> {
    T::deserialize(MapDeserializer::new(fields.into_iter()))
}

#[test]
fn what_is_read_is_checked() {
    let margins = |proximity| read::<Margins>([("clearance", 0.5), ("proximity", proximity)]);
    assert_eq!(margins(2.0), Ok(Margins::new(0.5, 2.0).expect("in range")));
    let refused = margins(0.0).expect_err("no distance").to_string();
    assert_eq!(refused, "proximity distance is 0, but must be finite and above 0");
    let spring = |stiffness| read::<SpringDamper>([("stiffness", stiffness), ("damping", 0.0)]);
    assert!(spring(1.0).is_ok() && spring(-1.0).is_err());

    // An enumeration is a map with one entry.
    let share = |mu| {
        let rule = MapDeserializer::new([("Share", mu)].into_iter());
        Friction::deserialize(MapAccessDeserializer::new(rule))
    };
    let refused: Result<Friction, Error> = share(1.5);
    assert_eq!(share(0.5), Ok::<_, Error>(Friction::share(0.5).expect("in range")));
    let refused = refused.expect_err("above 1").to_string();
    assert!(refused.starts_with("friction share is 1.5"), "{refused}");
}
