//! Words of other programs: the sentence says whether there is such a thing here, and what takes its place.

const SYMMETRIC: &str = "there are no problems with an axis of symmetry: take a sector as a solid, with rollers (`normal = 0.0`) on its two flat sides";
const LINEAR: &str = "materials are linear and elastic: nothing yields, creeps or breaks";
const SMALL: &str = "displacements and strains are small throughout: there is no setting for large ones";
const STATIC: &str = "there are no dynamics: loads are slow, and inertia is a `body_force`";
const EXACT: &str = "contact is exact, without a penalty: nothing is to be set";
const FRICTION: &str = "friction is a table of the contact: `friction = { law = \"coulomb\", mu = 0.3 }`";
const GAP: &str = "this is `gap`: a distance is positive, an interference negative";
const YOUNG: &str = "Young's modulus is `young`";
const POISSON: &str = "Poisson's ratio is `poisson`";
const ORDER: &str = "elements are linear; quadratic ones of mesh files are reduced to their corners";
const SYMMETRY: &str =
    "symmetry is a roller on the plane of symmetry: a [[body.displacement]] with `normal = 0.0`";

/// Words with their sentences, in small letters and without blanks and signs.
const WORDS: [(&str, &str); 42] = [
    ("axisymmetric", SYMMETRIC),
    ("axisymmetry", SYMMETRIC),
    ("axialsymmetry", SYMMETRIC),
    ("symmetry", SYMMETRY),
    ("plasticity", LINEAR),
    ("plastic", LINEAR),
    ("yield", LINEAR),
    ("yieldstress", LINEAR),
    ("yieldstrength", LINEAR),
    ("hardening", LINEAR),
    ("hyperelastic", LINEAR),
    ("creep", LINEAR),
    ("viscosity", LINEAR),
    ("damage", LINEAR),
    ("nlgeom", SMALL),
    ("largedisplacement", SMALL),
    ("largedisplacements", SMALL),
    ("largestrain", SMALL),
    ("finitestrain", SMALL),
    ("damping", STATIC),
    ("mass", STATIC),
    ("frequency", STATIC),
    ("velocity", STATIC),
    ("penalty", EXACT),
    ("penaltystiffness", EXACT),
    ("contactstiffness", EXACT),
    ("mu", FRICTION),
    ("frictioncoefficient", FRICTION),
    ("coefficientoffriction", FRICTION),
    ("clearance", GAP),
    ("overclosure", GAP),
    ("overlap", GAP),
    ("pressfit", GAP),
    ("shrinkfit", GAP),
    ("e", YOUNG),
    ("youngsmodulus", YOUNG),
    ("modulus", YOUNG),
    ("nu", POISSON),
    ("poissonratio", POISSON),
    ("poissonsratio", POISSON),
    ("order", ORDER),
    ("quadratic", ORDER),
];

/// Says whether there is what a word of another program means; `None` for all other words.
pub(super) fn sentence(word: &str) -> Option<String> {
    let letters: String = word.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect();
    let found = WORDS.iter().find(|(known, _)| *known == letters);
    found.map(|(_, sentence)| (*sentence).to_owned())
}
