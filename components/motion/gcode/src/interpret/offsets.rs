//! Planes, units, distance modes, coordinate systems and their offsets.

use super::{Interpreter, Run, block::Block, codes::GGroup};
use crate::{
    axis::{Axis, Position},
    canon::{Call, PathMode, Plane, Unit},
    error::Problem,
    parameters::number,
    question::Request,
};

impl Interpreter {
    /// Takes the coordinate system and G92 from the parameters, as at power-on.
    pub(super) fn load_system(&mut self) {
        let system = self.state.numbered.get(number::SYSTEM);
        let system = crate::text::evaluate::integer(system).ok().and_then(|s| u8::try_from(s).ok());
        let system = system.filter(|s| (1..=9).contains(s)).unwrap_or(1);
        let k = self.state.settings.unit.to(self.state.frame.unit);
        let (offset, rotation) = stored(&self.state.numbered, system);
        self.state.modal.system = system;
        self.state.frame.g5x = offset.scaled(k);
        self.state.frame.rotation = rotation;
        if self.state.numbered.get(number::G92_APPLIES) != 0.0 {
            self.state.frame.g92 = read(&self.state.numbered, number::G92).scaled(k);
        }
        self.state.position = self.state.frame.program(Position::default());
    }
}

/// Reads nine parameters as a position.
fn read(numbered: &crate::parameters::Numbered, first: i32) -> Position {
    let mut out = Position::default();
    for axis in Axis::ALL {
        out[axis] = numbered.get(first + i32::from(axis.index()));
    }
    out
}

fn first_of(system: u8) -> i32 {
    number::G54 + number::SYSTEM_STEP * (i32::from(system) - 1)
}

fn stored(numbered: &crate::parameters::Numbered, system: u8) -> (Position, f64) {
    let first = first_of(system);
    (read(numbered, first), numbered.get(first + number::G54_ROTATION - number::G54))
}

impl Run<'_> {
    pub(crate) fn stored_offset(&self, system: u8) -> (Position, f64) {
        stored(&self.state.numbered, system)
    }

    fn store(&mut self, first: i32, position: Position) {
        for axis in Axis::ALL {
            self.state.numbered.put(first + i32::from(axis.index()), position[axis]);
        }
    }

    pub(super) fn dwell(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        if b.g(GGroup::Once) != Some(40) {
            return Ok(None);
        }
        let seconds = b.get(b'p').ok_or(Problem::DwellTime)?;
        if seconds < 0.0 {
            return Err(Problem::DwellNegative);
        }
        self.emit(Call::Dwell(seconds))?;
        Ok(None)
    }

    pub(super) fn plane(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let plane = match b.g(GGroup::Plane) {
            None => return Ok(None),
            Some(170) => Plane::Xy,
            Some(180) => Plane::Xz,
            Some(190) => Plane::Yz,
            Some(171) => Plane::Uv,
            Some(181) => Plane::Uw,
            Some(_) => Plane::Vw,
        };
        if self.state.compensation.is_on() && plane != self.state.modal.plane {
            return Err(Problem::CompPlaneChange);
        }
        self.state.modal.plane = plane;
        self.emit(Call::SelectPlane(plane))?;
        Ok(None)
    }

    pub(super) fn unit(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let unit = match b.g(GGroup::Unit) {
            None => return Ok(None),
            Some(200) => Unit::Inch,
            Some(_) => Unit::Millimetre,
        };
        if self.state.compensation.is_on() {
            return Err(Problem::CompUnits);
        }
        self.set_unit(unit)?;
        Ok(None)
    }

    /// Sets the unit of the lengths that follow.
    pub(super) fn set_unit(&mut self, unit: Unit) -> Result<(), Problem> {
        let k = self.state.frame.unit.to(unit);
        self.emit(Call::UseLengthUnits(unit))?;
        self.state.position = self.state.position.scaled(k);
        self.state.frame = self.state.frame.in_unit(unit);
        self.state.modal.unit = unit;
        self.state.cycle.scale(k);
        self.state.spline = self.state.spline.map(|(x, y)| (x * k, y * k));
        Ok(())
    }

    pub(super) fn lathe_mode(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.g(GGroup::Lathe) else { return Ok(None) };
        if self.state.modal.diameter == (code == 70) {
            return Ok(None);
        }
        self.state.modal.diameter = code == 70;
        let name = if code == 70 { "diameter" } else { "radius" };
        self.note(&format!("Lathe diameter mode changed to {name}"))?;
        Ok(None)
    }

    pub(super) fn distance(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let absolute = match b.g(GGroup::Distance) {
            None => return Ok(None),
            Some(code) => code == 900,
        };
        if absolute != self.state.modal.absolute {
            let name = if absolute { "absolute" } else { "incremental" };
            self.note(&format!("distance mode changed to {name}"))?;
            self.state.modal.absolute = absolute;
        }
        Ok(None)
    }

    pub(super) fn ijk_distance(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let absolute = match b.g(GGroup::IjkDistance) {
            None => return Ok(None),
            Some(code) => code == 901,
        };
        if absolute != self.state.modal.ijk_absolute {
            let name = if absolute { "absolute" } else { "incremental" };
            self.note(&format!("IJK distance mode changed to {name}"))?;
            self.state.modal.ijk_absolute = absolute;
        }
        Ok(None)
    }

    pub(super) fn retract(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.g(GGroup::Retract) else { return Ok(None) };
        self.state.modal.retract_old = code == 980;
        let name = if code == 980 { "old_z" } else { "r_plane" };
        self.note(&format!("retract mode set to {name}"))?;
        Ok(None)
    }

    pub(super) fn path_mode(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.g(GGroup::Path) else { return Ok(None) };
        let tolerance = b.get(b'p').unwrap_or(0.0);
        let path = match code {
            610 => PathMode::ExactPath,
            611 => PathMode::ExactStop,
            _ => PathMode::Continuous { tolerance },
        };
        let naive = b.get(b'q').unwrap_or(tolerance);
        self.set_path(path, naive)?;
        Ok(None)
    }

    pub(crate) fn set_path(&mut self, path: PathMode, naive: f64) -> Result<(), Problem> {
        self.state.modal.path = path;
        self.emit(Call::SetPathMode(path))?;
        if matches!(path, PathMode::Continuous { .. }) {
            self.state.modal.naive_tolerance = naive;
            self.emit(Call::SetNaiveCamTolerance(naive))?;
        }
        Ok(())
    }

    pub(super) fn coordinate_system(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let system = match b.g(GGroup::System) {
            None => return Ok(None),
            Some(code @ 540..=590) => code / 10 - 53,
            Some(code) => code - 590 + 6,
        };
        let system = u8::try_from(system).unwrap_or(1);
        if self.state.compensation.is_on() {
            return Err(Problem::OffsetWithComp { what: "Cannot change coordinate systems" });
        }
        if system == self.state.modal.system {
            self.note("continuing to use same coordinate system")?;
            return Ok(None);
        }
        self.state.modal.system = system;
        self.state.numbered.put(number::SYSTEM, f64::from(system));
        let k = self.table_scale();
        let machine = self.state.frame.machine(self.state.position);
        let (offset, rotation) = self.stored_offset(system);
        let frame = &mut self.state.frame;
        frame.g5x = offset.scaled(k);
        frame.rotation = rotation;
        let applies = self.state.numbered.get(number::G92_APPLIES) != 0.0;
        frame.g92 = if applies {
            read(&self.state.numbered, number::G92).scaled(k)
        } else {
            Position::default()
        };
        self.state.position = self.state.frame.program(machine);
        let (offset, g92) = (self.state.frame.g5x, self.state.frame.g92);
        self.emit(Call::SetG5xOffset { system, offset })?;
        self.emit(Call::SetG92Offset(g92))?;
        self.emit(Call::SetXyRotation(rotation))?;
        Ok(None)
    }

    /// Runs G10, G28, G30, G52 and G92.
    pub(super) fn once(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        match b.g(GGroup::Once) {
            Some(100) => self.g10(b)?,
            Some(280) => self.home(b, number::G28)?,
            Some(300) => self.home(b, number::G30)?,
            Some(281) => self.set_home(number::G28),
            Some(301) => self.set_home(number::G30),
            Some(520 | 920..=923) => self.g92(b)?,
            _ => {}
        }
        Ok(None)
    }

    fn set_home(&mut self, first: i32) {
        let k = 1.0 / self.table_scale();
        let machine = self.state.frame.machine(self.state.position);
        self.store(first, machine.scaled(k));
    }

    fn home(&mut self, b: &Block, first: i32) -> Result<(), Problem> {
        if self.state.compensation.is_on() {
            return Err(Problem::CompMotion {
                what: "Cannot use g28 or g30 with cutter radius comp",
            });
        }
        let intermediate = self.target(b)?;
        let k = self.table_scale();
        let home = read(&self.state.numbered, first).scaled(k);
        let home = self.state.frame.program(home);
        let mut end = intermediate;
        for axis in Axis::ALL {
            if !b.has_axes() || b.has(axis.letter() as u8) {
                end[axis] = home[axis];
            }
        }
        self.emit(Call::StraightTraverse(intermediate))?;
        self.emit(Call::StraightTraverse(end))?;
        self.state.position = end;
        Ok(())
    }

    fn g10(&mut self, b: &Block) -> Result<(), Problem> {
        match b.integer(b'l')?.ok_or(Problem::G10NeedsL)? {
            0 => {
                self.state.changed_tools.clear();
                self.emit(Call::ReloadToolData)
            }
            l @ (1 | 10 | 11) => self.set_tool(b, l),
            l @ (2 | 20) => self.set_system(b, l == 20),
            _ => Err(Problem::G10LRange),
        }
    }

    fn set_system(&mut self, b: &Block, from_position: bool) -> Result<(), Problem> {
        let active = self.state.modal.system;
        let system = match b.integer(b'p')?.ok_or(Problem::G10PRange)? {
            0 => active,
            p => u8::try_from(p).ok().filter(|p| *p <= 9).ok_or(Problem::G10PRange)?,
        };
        if from_position && b.has(b'r') {
            return Err(Problem::G10AxisRotation);
        }
        if system == active && self.state.compensation.is_on() {
            let what = "Cannot change the active coordinate system";
            return Err(Problem::OffsetWithComp { what });
        }
        let (mut offset, mut rotation) = self.stored_offset(system);
        if let Some(r) = b.get(b'r') {
            rotation = r;
        }
        let k = self.table_scale();
        offset = offset.scaled(k);
        if from_position {
            // The program's place in this system becomes the words: move the offset by the difference, turned.
            let mut frame = self.state.frame;
            let machine = frame.machine(self.state.position);
            frame.g5x = offset;
            frame.rotation = rotation;
            let here = frame.program(machine);
            let mut wanted = here;
            for axis in Axis::ALL {
                if let Some(v) = b.get(axis.letter() as u8) {
                    wanted[axis] = v;
                }
            }
            offset = offset + (here - wanted).rotated(rotation);
        } else {
            for axis in Axis::ALL {
                if let Some(v) = b.get(axis.letter() as u8) {
                    offset[axis] = v;
                }
            }
        }
        let first = first_of(system);
        self.store(first, offset.scaled(1.0 / k));
        self.state.numbered.put(first + number::G54_ROTATION - number::G54, rotation);
        if system != active {
            return self.note("setting coordinate system origin");
        }
        let machine = self.state.frame.machine(self.state.position);
        self.state.frame.g5x = offset;
        self.state.frame.rotation = rotation;
        self.state.position = self.state.frame.program(machine);
        self.emit(Call::SetG5xOffset { system, offset })?;
        self.emit(Call::SetXyRotation(rotation))
    }

    fn g92(&mut self, b: &Block) -> Result<(), Problem> {
        let code = b.g(GGroup::Once);
        if self.state.compensation.is_on() {
            return Err(Problem::G92WithComp);
        }
        let old = self.state.frame.g92;
        let k = self.table_scale();
        let mut new = old;
        match code {
            Some(920) => {
                for axis in Axis::ALL {
                    if let Some(v) = b.get(axis.letter() as u8) {
                        new[axis] = old[axis] + self.state.position[axis] - v;
                    }
                }
            }
            Some(520) => {
                for axis in Axis::ALL {
                    if let Some(v) = b.get(axis.letter() as u8) {
                        new[axis] = v;
                    }
                }
            }
            Some(923) => new = read(&self.state.numbered, number::G92).scaled(k),
            _ => new = Position::default(),
        }
        let applies = matches!(code, Some(920 | 520 | 923));
        self.set_g92(new)?;
        self.state.numbered.put(number::G92_APPLIES, if applies { 1.0 } else { 0.0 });
        if !matches!(code, Some(922 | 923)) {
            self.store(number::G92, new.scaled(1.0 / k));
        }
        Ok(())
    }

    /// Keeps an offset of G92 in its parameters; one without length does not apply.
    pub(super) fn keep_g92(&mut self, offset: Position) {
        let applies = offset != Position::default();
        self.state.numbered.put(number::G92_APPLIES, if applies { 1.0 } else { 0.0 });
        self.store(number::G92, offset.scaled(1.0 / self.table_scale()));
    }

    pub(crate) fn set_g92(&mut self, new: Position) -> Result<(), Problem> {
        let old = self.state.frame.g92;
        self.state.position = self.state.position + old - new;
        self.state.frame.g92 = new;
        self.emit(Call::SetG92Offset(new))
    }
}
