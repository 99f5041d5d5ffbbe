//! The bodies of a case, with fem-core's errors at the places of their keys.

use super::{Case, Dimension, MeshSource, fixes};
use crate::diagnostic::{CaseError, Diagnostic, SourcePosition, code, did_you_mean};
use contact_geometry::ContactNormal;
use fem_core::body::{Body, BodyError, ConditionList, ConditionPlace};
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Point;
use fem_core::interface::{Gap, InterfaceError};
use fem_core::material::MaterialError;
use fem_core::mesh::{Mesh, MeshError};

impl<S: Dimension> Case<S> {
    /// Makes the bodies in the file's order: mesh, material and evaluated conditions.
    ///
    /// # Errors
    /// Everything that fem-core refuses of a body, at the place of the key that causes it.
    pub fn build_bodies(&self) -> Result<Vec<Body<S>>, CaseError> {
        let (mut bodies, mut faults) = (Vec::new(), Vec::new());
        for body in fem_core::each_body(self.bodies.len(), |body| self.build_body(body)) {
            match body {
                Ok(body) => bodies.push(body),
                Err(error) => faults.extend(error.diagnostics),
            }
        }
        if !faults.is_empty() {
            return Err(CaseError::new(faults));
        }
        self.check_pieces(&bodies)?;
        Ok(bodies)
    }

    /// Lists the sides of a body that are in contact.
    fn sides_of(&self, body: usize) -> impl Iterator<Item = &str> {
        self.contacts.iter().flat_map(move |contact| {
            let members = contact.bodies.iter().zip(&contact.surfaces);
            members.filter(move |(b, _)| **b == body).map(|(_, side)| side.as_str())
        })
    }

    /// Refuses a piece of one body that takes no part in any contact and lies inside another body.
    fn check_pieces(&self, bodies: &[Body<S>]) -> Result<(), CaseError> {
        for b in 0..bodies.len() {
            let mesh = bodies[b].mesh();
            let (piece_of, count) = mesh.topology().pieces();
            if count < 2 {
                continue;
            }
            let sides: Vec<_> = self.sides_of(b).filter_map(|side| mesh.group(side)).collect();
            if sides.is_empty() {
                continue;
            }
            let mut in_contact = vec![false; count];
            for &facet in sides.into_iter().flatten() {
                in_contact[piece_of[mesh.topology().facets()[facet][0]] as usize] = true;
            }
            let apart = |t: &u32| !in_contact[piece_of[mesh.cells()[*t as usize][0]] as usize];
            let cells: Vec<u32> = (0..mesh.cells().len() as u32).filter(apart).collect();
            let others = (0..bodies.len()).filter(|other| *other != b);
            let overlap = |other: usize| Some((other, mesh.overlap_with(&cells, bodies[other].mesh())?));
            let Some((other, found)) = others.filter_map(overlap).next() else { continue };
            let element = |b: usize, t: usize| match self.element_numbers(b, bodies[b].mesh()) {
                Some(numbers) => numbers.get(t).copied().unwrap_or_default(),
                None => t as u64,
            };
            let message = format!(
                "body \"{}\": a piece of it that has no contact {} lies inside body \"{}\": the elements {} and {} overlap at {}",
                self.bodies[b].name,
                S::WORDS.facet,
                self.bodies[other].name,
                element(b, found.cells[0]),
                element(other, found.cells[1]),
                Point::from(found.point)
            );
            let fault = self.diagnostic(code::MESH, &format!("body.{b}.mesh.file"), message);
            let fault = fault.expected("bodies that cover no place twice");
            return Err(fault
                .fix("take this piece out of the region of the body, or give it to the other body")
                .into());
        }
        Ok(())
    }

    /// Makes one body.
    ///
    /// # Errors
    /// See [`Case::build_bodies`].
    pub(crate) fn build_body(&self, body: usize) -> Result<Body<S>, CaseError> {
        let mesh = self.build_mesh(body)?;
        let materials = self.build_materials(body, &mesh)?;
        let conditions = self.boundary_conditions(body);
        let made = Body::new(mesh, materials, &conditions)
            .and_then(|made| S::curved(made, &self.bodies[body].curves));
        made.map_err(|error| self.body_diagnostic(body, &error).into())
    }

    /// Makes the mesh of one body.
    ///
    /// # Errors
    /// A mesh that cannot be generated, or a file that was not read or holds no sound mesh.
    pub(crate) fn build_mesh(&self, body: usize) -> Result<Mesh<S>, CaseError> {
        let mut mesh = self.mesh_as_made(body)?;
        self.add_sides(body, &mut mesh)?;
        Ok(mesh)
    }

    /// Makes the mesh of one body without the sides of `[[body.side]]`.
    fn mesh_as_made(&self, body: usize) -> Result<Mesh<S>, CaseError> {
        match &self.bodies[body].mesh {
            MeshSource::File { .. } => self.mesh_of_file(body),
            MeshSource::Generator(generator) => {
                S::generated(generator).map_err(|error| self.mesh_diagnostic(body, &error).into())
            }
        }
    }

    /// Returns the gap and the normal of a pair as the case gives them.
    pub(super) fn gap_and_normal(&self, contact: usize) -> (Gap<S>, ContactNormal<S>) {
        let given = &self.contacts[contact];
        let gap = match (&given.bond, given.geometric) {
            (Some(offset), _) => Gap::Bonded { offset: S::vector(offset) },
            (None, true) if given.interference => Gap::Interference,
            (None, true) => Gap::Geometric,
            (None, false) if self.is_given(&format!("{}.gap", given.path)) => Gap::Given(given.gap.scalar()),
            (None, false) => Gap::Touching,
        };
        (gap, given.normal.as_ref().map_or(ContactNormal::Averaged, |n| ContactNormal::Fixed(S::vector(n))))
    }

    /// Attributes an error of a body's boundary conditions to the condition's key.
    pub(crate) fn body_diagnostic(&self, body: usize, error: &BodyError) -> Diagnostic {
        let of = |place: &ConditionPlace, key: &str| {
            let list = match place.list {
                ConditionList::Displacement => "displacement",
                ConditionList::Traction => "traction",
                ConditionList::Rigid => "rigid",
                ConditionList::Spring => "spring",
                ConditionList::Curve => "curve",
                ConditionList::Surface => "surface",
                ConditionList::Temperature => "temperature",
                ConditionList::BodyForce => "body_force",
                ConditionList::Cut => "cut",
            };
            format!("body.{body}.{list}.{}{key}", place.index)
        };
        let mut help = None;
        let path = match error {
            BodyError::UnknownGroup { place, group, known, .. } => {
                help = self
                    .region_not_side(body, group)
                    .or_else(|| self.side_of_other(body, group))
                    .or_else(|| did_you_mean(group, known.split(", "), '"'));
                of(place, ".on")
            }
            BodyError::InteriorFacet { place, .. } | BodyError::CurvedTwice { place, .. } => of(place, ".on"),
            BodyError::NoNode { place, .. } => {
                let on = self.bodies[body].displacements.get(place.index).map(|given| &given.on);
                let side = self.bodies[body].sides.iter().position(|side| Some(&side.name) == on);
                side.map_or_else(|| of(place, ".on"), |k| format!("body.{body}.side.{k}.point"))
            }
            BodyError::SingleNode { place } => of(place, ".on"),
            BodyError::NoArc { place, .. }
            | BodyError::OffArc { place, .. }
            | BodyError::NoSurface { place, .. }
            | BodyError::OffSurface { place, .. } => of(place, ".kind"),
            BodyError::EmptySelection { place, .. } if self.is_given(&of(place, ".part")) => {
                of(place, ".part")
            }
            BodyError::EmptySelection { place, .. } => of(place, ".on"),
            BodyError::LoadOnSupport { place, .. } => self.load_path(&of(place, "")),
            BodyError::NotFinite { place, .. } => self.expression_path(&of(place, "")),
            BodyError::Stiffness { place, .. }
            | BodyError::TooStiff { place, .. }
            | BodyError::TooSoft { place, .. } => of(place, ".stiffness"),
            BodyError::SpringOnSupport { place, .. } => of(place, ""),
            BodyError::Conflict { place, .. } | BodyError::RigidOccupied { place, .. } => of(place, ""),
            BodyError::Materials { .. } => format!("body.{body}.material"),
            BodyError::BodyForce { .. } => format!("body.{body}.body_force"),
            BodyError::CutMisses { place, .. }
            | BodyError::CutEnds { place, .. }
            | BodyError::CutParts { place, .. }
            | BodyError::CutHeld { place, .. }
            | BodyError::CutTwice { place, .. } => of(place, ".plane"),
        };
        let message = format!(
            "body \"{}\": {error}{}",
            self.bodies[body].name,
            self.earlier(body, error).unwrap_or_default()
        );
        let (expected, fix) = fixes::of_body(error);
        self.diagnostic(code::CONDITION, &path, message).expected(expected).help(help).fix(fix)
    }

    /// Says where the earlier condition of a conflict is: the first that alone contradicts the later one.
    fn earlier(&self, body: usize, error: &BodyError) -> Option<String> {
        let BodyError::Conflict { place, .. } = error else { return None };
        if place.list == ConditionList::Rigid {
            return None;
        }
        let mesh = self.build_mesh(body).ok()?;
        let materials = self.build_materials(body, &mesh).ok()?;
        let all = self.boundary_conditions(body).displacements;
        let contradicts = |earlier: &usize| {
            let both = [*earlier, place.index].into_iter().filter_map(|k| all.get(k).cloned());
            let two = BoundaryConditions { displacements: both.collect(), ..BoundaryConditions::default() };
            matches!(Body::new(mesh.clone(), materials.clone(), &two), Err(BodyError::Conflict { .. }))
        };
        let earlier = (0..place.index).find(contradicts)?;
        let at = self.place(&format!("body.{body}.displacement.{earlier}"))?;
        Some(format!("; the earlier one is displacement condition {}, {at}", earlier + 1))
    }

    /// Helps if a side of another body is named, or a side with the name of its body in front.
    fn side_of_other(&self, body: usize, side: &str) -> Option<String> {
        (0..self.bodies.len()).filter(|b| *b != body).find_map(|other| self.side_of(body, other, side))
    }

    fn side_of(&self, body: usize, other: usize, side: &str) -> Option<String> {
        let [own, foreign] = [body, other].map(|b| &self.bodies[b].name);
        let behind = |name: &str| side.strip_prefix(name).and_then(|rest| rest.strip_prefix('.'));
        if let Some(alone) = behind(own)
            && self.build_mesh(body).ok()?.group(alone).is_some()
        {
            return Some(format!("write the name of the side alone: \"{alone}\""));
        }
        let mesh = self.build_mesh(other).ok()?;
        let named =
            [Some(side), behind(foreign)].into_iter().flatten().find(|name| mesh.group(name).is_some())?;
        Some(format!("\"{named}\" is a side of body \"{foreign}\": name a side of \"{own}\" here"))
    }

    /// Helps if each of the two contact surfaces of a pair is a side of the other body alone.
    ///
    /// * `side`: the side whose surface is not there, 0 or 1.
    fn surfaces_swapped(&self, contact: usize, side: usize) -> Option<String> {
        let given = &self.contacts[contact];
        let other = 1usize.checked_sub(side)?;
        let [a, b] = given.bodies[..] else { return None };
        let meshes = [self.build_mesh(a).ok()?, self.build_mesh(b).ok()?];
        let of = |b: usize, surface: usize| meshes[b].group(&given.surfaces[surface]).is_some();
        let swapped = of(side, other) && of(other, side) && !of(side, side);
        swapped.then(|| {
            "swap the two names: `surfaces` has a side of the first body, then one of the second".to_owned()
        })
    }

    fn load_path(&self, condition: &str) -> String {
        let keys = ["vector", "pressure"].map(|key| format!("{condition}.{key}"));
        keys.into_iter().find(|path| self.is_given(path)).unwrap_or_else(|| condition.to_owned())
    }

    /// Attributes an error of a body's mesh to its generator.
    pub(crate) fn mesh_diagnostic(&self, body: usize, error: &MeshError) -> Diagnostic {
        let message = format!("body \"{}\": {error}", self.bodies[body].name);
        generator_fault(self.place(&format!("body.{body}.generator")), message, error)
    }

    /// Attributes an error of a material to its key.
    pub(crate) fn material_diagnostic(&self, material: &str, error: &MaterialError) -> Diagnostic {
        let key = fixes::material_key(error);
        let (expected, fix) = fixes::of_material(error);
        self.diagnostic(code::VALUE, &format!("materials.{material}.{key}"), error.to_string())
            .expected(expected)
            .fix(fix)
    }

    /// Writes an error of a pair, which knows a body by its side only, with the name of the body.
    pub(super) fn with_name(
        &self,
        contact: usize,
        error: &dyn std::error::Error,
        side: Option<usize>,
    ) -> String {
        let message = error.to_string();
        let body = |side: usize| self.bodies.get(*self.contacts[contact].bodies.get(side)?);
        match side.and_then(|side| Some((side, body(side)?))) {
            Some((side, case)) => {
                message.replacen(&format!("body {side}"), &format!("body \"{}\"", case.name), 1)
            }
            None => message,
        }
    }

    /// Attributes an error of a pair to its table; bodies are called by their names.
    pub(crate) fn interface_diagnostic(&self, contact: usize, error: &InterfaceError) -> Diagnostic {
        let given = &self.contacts[contact];
        let mut help = None;
        let (key, side) = match error {
            InterfaceError::UnknownSurface { body: side, group, known, .. } => {
                let body = given.bodies.get(*side).copied().unwrap_or_default();
                help = self
                    .region_not_side(body, group)
                    .or_else(|| self.surfaces_swapped(contact, *side))
                    .or_else(|| self.side_of_other(body, group))
                    .or_else(|| did_you_mean(group, known.split(", "), '"'));
                (format!("surfaces.{side}"), Some(*side))
            }
            InterfaceError::NoSurface { body: side, .. }
            | InterfaceError::Occupied { body: side, .. }
            | InterfaceError::HeldAgainstSlip { body: side, .. }
            | InterfaceError::SupportedNode { body: side, .. } => (format!("surfaces.{side}"), Some(*side)),
            InterfaceError::NotMatching { body: side, .. }
            | InterfaceError::FacetWithoutPartner { body: side, .. } => ("surfaces".to_owned(), Some(*side)),
            InterfaceError::BadGap { .. }
            | InterfaceError::Distance { .. }
            | InterfaceError::NotTouching { .. }
            | InterfaceError::Overlap { .. }
            | InterfaceError::TooFar { .. } => ("gap".to_owned(), None),
            InterfaceError::TooDeep { body: side, .. } => ("gap".to_owned(), Some(*side)),
            InterfaceError::NormalAway { .. } => ("normal".to_owned(), None),
            InterfaceError::BadFrictionLimit { .. } => ("friction.limit".to_owned(), None),
            InterfaceError::BadFrictionCoefficient { .. } => ("friction.mu".to_owned(), None),
            _ => ("surfaces".to_owned(), None),
        };
        let (mut key, mut message) = (key, self.with_name(contact, error, side));
        let (mut expected, mut fix) = fixes::of_interface(error);
        help = help.or_else(|| fixes::press_fit(error));
        if given.obstacle.is_some()
            && let Some((said, of_obstacle)) = fixes::against_obstacle(error)
        {
            let name = given.bodies.first().and_then(|b| self.bodies.get(*b)).map_or("", |body| &body.name);
            message = format!("body \"{name}\" {said}");
            ((expected, fix), help) = (of_obstacle, None);
            if matches!(error, InterfaceError::Overlap { .. }) {
                key = "obstacle".to_owned();
            }
        }
        self.diagnostic(code::CONTACT, &format!("{}.{key}", given.path), message)
            .expected(expected)
            .help(help)
            .fix(fix)
    }
}

/// Makes the diagnostic of a generator that makes no mesh.
pub(super) fn generator_fault(
    place: Option<SourcePosition>,
    message: String,
    error: &MeshError,
) -> Diagnostic {
    let (expected, fix) = match error {
        MeshError::Scale { .. } => ("lengths whose cubes are numbers too", "check the unit of the lengths"),
        _ => (
            "a shape with an area, and cells that fit into it",
            "check the numbers of this generator; `nndd new paper` and `nndd new hertz` show sound ones",
        ),
    };
    Diagnostic::new(code::MESH, place, message).expected(expected).fix(fix)
}
