//! Rigid bodies of Abaqus input files: planted sets of parts, of instances and of the assembly.

use mesh_io::{parse_mesh, parse_parts, part_names};

use crate::inp_parts::{FLAT, names};

/// Sets that `*Rigid Body` names: of a part, of the assembly with members of an instance, of sets, and of a file without
/// parts. Names of the assembly are not those of a part, and an instance has the sets of its part and its own.
#[test]
fn parts_are_rigid_by_the_sets_of_rigid_bodies() {
    let part = |name: &str, rest: &str| {
        format!(
            "*Part, name={name}\n*Node\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n5, 1, 1, 1\n\
             *Element, type=C3D4, elset=upper\n10, 1, 2, 3, 4\n*Element, type=C3D4, elset=lower\n20, 2, 5, 3, 4\n\
             *Element, type=MASS, elset=mass\n1, 1\n{rest}*End Part\n"
        )
    };
    let model = |rest: &str, assembly: &str| {
        let (p, q) = (part("p", rest), part("q", ""));
        format!(
            "{p}{q}*Assembly, name=a\n*Instance, name=p-1, part=P\n*End Instance\n\
             *Instance, name=p-2, part=p\n*Elset, elset=both\n10, 20\n*End Instance\n\
             *Instance, name=q-1, part=q\n*End Instance\n*Node\n1, 0, 0, 0\n{assembly}*End Assembly\n"
        )
    };
    let rigid = |model: &str| -> Vec<String> {
        let all = part_names(model.as_bytes(), "inp").expect(model);
        let mut rigid = Vec::new();
        for name in all {
            let meshes =
                parse_parts(model.as_bytes(), "inp", &[std::slice::from_ref(&name)]).expect(model);
            rigid.extend(meshes[0].is_rigid.then_some(name));
        }
        rigid
    };

    let body = |set: &str| format!("*Rigid Body, ref node=1, elset={set}\n");
    let set = |name: &str, members: &str| format!("*Elset, elset={name}\n{members}\n");
    for (rest, assembly, expected) in [
        (set("all", "Upper, 20") + &body("ALL"), String::new(), vec!["p-1", "p-2"]),
        (body("upper"), String::new(), vec![]),
        (body("upper") + &body("lower"), String::new(), vec!["p-1", "p-2"]),
        // What the assembly names in the same way is another set.
        (set("all", "10, 20"), body("all"), vec![]),
        (String::new(), body("upper") + &body("lower"), vec![]),
        (set("all", "10, 20"), body("p-2.all"), vec!["p-2"]),
        (String::new(), body("p-2.both") + &body("p-1.both"), vec!["p-2"]),
        (
            set("all", "lower, upper"),
            "*Elset, elset=s, internal, instance=P-1\nall\n".to_owned() + &body("s"),
            vec!["p-1"],
        ),
        (
            String::new(),
            "*Elset, elset=s, instance=q-1, generate\n10, 20, 10\n".to_owned() + &body("s"),
            vec!["q-1"],
        ),
        (
            String::new(),
            set("s", "q-1.10, p-2.upper, q-1.lower, p-2.20, p-1.10") + &body("s"),
            vec!["p-2", "q-1"],
        ),
        // A set that holds itself.
        (String::new(), set("s", "s, t") + &set("t", "s, p-1.upper") + &body("t"), vec![]),
    ] {
        assert_eq!(rigid(&model(&rest, &assembly)), expected, "{rest}{assembly}");
    }

    let flat = format!("{FLAT}{}{}", set("s", "upper"), body("s"));
    let of_set = |set: &str| parse_parts(flat.as_bytes(), "inp", &[&names(&[set])]).expect(set);
    assert!(of_set("upper")[0].is_rigid && !of_set("skin")[0].is_rigid, "{flat}");
    let one = part("p", "") + "*Assembly\n*Instance, name=i, part=p\n*End Instance\n";
    let whole = |text: &str| parse_mesh(text.as_bytes(), "inp").expect(text).is_rigid;
    assert!(whole(&format!("{one}*Elset, elset=s, instance=i\nupper, 20\n{}", body("s"))));
    assert!(!whole(&format!("{one}*Elset, elset=s, instance=i\nupper\n{}", body("s"))));
    assert!(!whole(&one));
}
