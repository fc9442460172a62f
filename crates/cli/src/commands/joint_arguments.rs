//! Arguments of joint contact, shared by the commands that measure it.

use std::str::FromStr;

use clap::{Args, ValueEnum};
use musculo_collide::{
    ElasticFoundation, FoundationLaw, JointContactParams, PairId, Progress, Scene,
};

use crate::failure::Failure;
use crate::load::LoadedScene;
use crate::report::PairContact;

/// Parameters of joint contact, with lengths in the scene's unit.
#[derive(Debug, Args)]
pub(super) struct JointArgs {
    /// Measure the contact of each pair, where the gap is at most this length, in the scene's unit:
    /// area, center and gaps, of both surfaces and each region. Gaps below 0 are depths
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    joint_contact: Option<f64>,

    /// Radius of the cells that are summed up, in the scene's unit: half of it halves the bracket
    /// of areas and takes four times as long [default: a quarter of the mean edge length]
    #[arg(long, value_name = "LENGTH", requires = "joint_contact", allow_negative_numbers = true)]
    joint_resolution: Option<f64>,

    /// Elastic layer that presses back where surfaces overlap: Young's modulus as force per area,
    /// Poisson's ratio, and thickness of both layers together in the scene's unit. Adds pressures in
    /// the modulus's unit, and forces
    #[arg(
        long,
        value_name = "MODULUS,POISSON,THICKNESS",
        requires = "joint_contact",
        allow_hyphen_values = true
    )]
    foundation: Option<Layer>,

    /// Dependence of the pressure on the strain [default: linear]
    #[arg(long, value_name = "LAW", requires = "foundation")]
    foundation_law: Option<LawName>,
}

/// Elastic layer without its law.
#[derive(Clone, Copy, Debug)]
struct Layer {
    youngs_modulus: f64,
    poissons_ratio: f64,
    thickness: f64,
}

/// Dependence of the pressure on the strain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum LawName {
    /// Proportional: for small strains
    #[default]
    Linear,
    /// Stiffer the more the layer is compressed
    Logarithmic,
}

impl FromStr for Layer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut numbers = Vec::new();
        for part in text.split(',') {
            let number = part.trim().parse::<f64>();
            numbers.push(number.map_err(|_| format!("'{part}' is no number"))?);
        }
        let [youngs_modulus, poissons_ratio, thickness] = numbers[..] else {
            return Err("expected three numbers, separated by commas".to_owned());
        };
        Ok(Self { youngs_modulus, poissons_ratio, thickness })
    }
}

/// Resolution in mean edges: some dozen cells per face.
const RESOLUTION_IN_EDGES: f64 = 0.25;

impl JointArgs {
    /// Returns the parameters, where joint contact is asked for. The margin within which pairs are
    /// near is at least that of joint contact.
    pub(super) fn params(
        &self,
        loaded: &mut LoadedScene,
    ) -> Result<Option<JointContactParams>, Failure> {
        let Some(margin) = self.joint_contact else { return Ok(None) };
        let law = match self.foundation_law.unwrap_or_default() {
            LawName::Linear => FoundationLaw::Linear,
            LawName::Logarithmic => FoundationLaw::Logarithmic,
        };
        let mut foundation = None;
        if let Some(Layer { youngs_modulus, poissons_ratio, thickness }) = self.foundation {
            foundation = Some(ElasticFoundation { youngs_modulus, poissons_ratio, thickness, law });
        }

        let edge = loaded.mean_edge();
        let resolution = self.joint_resolution.unwrap_or(RESOLUTION_IN_EDGES * edge);
        let params = JointContactParams { margin, resolution, foundation };
        params.validate()?;
        loaded.description.margin = Some(loaded.margin().max(margin));
        Ok(Some(params))
    }
}

/// Measures the joint contact of some pairs, and keeps those in contact.
pub(super) fn joint_contacts(
    scene: &mut Scene,
    pairs: &[PairId],
    params: &JointContactParams,
    progress: Progress<'_>,
) -> Result<Vec<PairContact>, Failure> {
    let measured = scene.joint_contacts(pairs, params, progress)?;
    let mut contacts = Vec::new();
    for (&pair, sides) in pairs.iter().zip(measured) {
        if sides.iter().any(|side| !side.faces.is_empty()) {
            contacts.push(PairContact { pair, sides });
        }
    }
    Ok(contacts)
}
