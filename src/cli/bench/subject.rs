//! One device, being measured.
//!
//! The same is done on every device: fixed numbers of frames and rounds, fixed seeds, a warm-up, everything offscreen.
//! Nothing of the device is locked or changed. What a submission asks of it is bounded
//! ([`PART_COMPARISONS`](crate::cli::session::PART_COMPARISONS)), so that no watchdog resets a slow one.

use super::catalogue::{technique_name, Case, MotionName, SceneName, Work};
use super::check::{share_allowed, Outcome, References};
use super::results::{FailedMeasurement, Kind, Measurement, Telemetry};
use super::rounds::{Figures, Rounds, Time};
use super::scenes::Model;
use super::synthesis::Problem;
use super::telemetry::Reader;
use super::throughput::Stream;
use super::Effort;
use crate::cli::failure::{Failure, Result};
use crate::cli::image_frames::{Continuity, NextFrame};
use crate::cli::painter::{Painter, Scene};
use crate::cli::progress::Progress;
use crate::cli::quilting::SearchFlag;
use crate::cli::session::{Device, Session, PART_COMPARISONS};
use crate::cli::techniques::{Chosen, Technique, TechniqueName};
use crate::cli::values::Size;
use impasto::gpu::Uploads;
use impasto::scene::Moment;
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::Quilt;
use impasto::synthesis::repair::RepairParams;
use impasto::technique::aligned::{AlignedFrame, LevelParams};
use impasto::technique::dependent::{default_views, DependentParams};
use impasto::technique::image::ImageParams;
use impasto::technique::object::ObjectParams;
use impasto::technique::Show;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

/// Side of the texture of each view, pixels.
const VIEW_PX: u32 = 512;

/// What all devices of a run share.
#[derive(Default)]
pub struct Shared {
    models: HashMap<SceneName, Rc<Model>>,
    /// Hashes of what the CPU oracle makes, by the names of cases.
    oracles: HashMap<String, Option<String>>,
    references: References,
}

impl Shared {
    pub(super) fn model(&mut self, scene: SceneName) -> Result<Rc<Model>> {
        if let Some(model) = self.models.get(&scene) {
            return Ok(model.clone());
        }
        Ok(self.models.entry(scene).insert_entry(Rc::new(Model::new(scene)?)).get().clone())
    }

    fn oracle(&mut self, case: &Case, problem: &Problem) -> Result<Option<String>> {
        if let Some(known) = self.oracles.get(&case.id) {
            return Ok(known.clone());
        }
        Ok(self.oracles.entry(case.id.clone()).insert_entry(problem.oracle()?).get().clone())
    }
}

/// A device, and what was found so far.
pub struct Subject<'a> {
    pub effort: &'a Effort,
    pub shared: &'a mut Shared,
    pub progress: &'a Progress,
    /// Shows nothing.
    pub session: Session,
    pub device: Device,
    /// What tells of clocks, temperature and power.
    pub telemetry: Option<Reader>,
    /// Milliseconds, by technique.
    pub compile_ms: BTreeMap<String, f64>,
    pub measurements: Vec<Measurement>,
    pub failures: Vec<FailedMeasurement>,
    /// What was prepared before.
    pub warm: Vec<(TechniqueName, Size)>,
    /// How the device was when something was measured last.
    pub state: Option<Telemetry>,
    /// The hash that throughput has with the first number of frames in flight.
    pub stream_hash: Option<String>,
}

impl Subject<'_> {
    /// Measures these cases in their order. A case that fails is told among the failures, and the next one follows.
    ///
    /// # Errors
    /// What the device failed at when it was lost or stuck.
    pub fn measure(&mut self, cases: &[Case]) -> Result {
        self.compile(cases)?;
        for group in cases.chunk_by(|a, b| a.prepared().is_some() && a.prepared() == b.prepared()) {
            let result = match (group[0].prepared(), group[0].work) {
                (Some((technique, scene, size)), _) => self.prepared(technique, scene, size, group),
                (None, Work::Throughput { in_flight }) => self.throughput(&group[0], in_flight),
                (None, _) => self.synthesis(&group[0]),
            };
            self.go_on(group, result)?;
        }
        Ok(())
    }

    /// Takes note that those of the cases failed that have not been measured.
    fn go_on(&mut self, cases: &[Case], result: Result) -> Result {
        let Err(failure) = result else { return Ok(()) };
        for case in cases {
            let id = case.id(self.effort.sustained);
            let known = self.failures.iter().any(|one| one.id == id);
            if !known && !self.measurements.iter().any(|one| one.id == id) {
                self.failures.push(FailedMeasurement { id, error: failure.0.clone() });
                self.progress.step();
            }
        }
        self.if_alive(failure)
    }

    /// Fails if the device does not run anything any more: it is lost, or stuck.
    pub(super) fn if_alive(&mut self, failure: Failure) -> Result {
        self.device.runner.run(|_| Ok(())).map_err(|_| failure)
    }

    /// Prepares a technique for a scene and a size, and measures all that asks for it.
    fn prepared(&mut self, technique: TechniqueName, scene: SceneName, size: Size, cases: &[Case]) -> Result {
        let model = self.shared.model(scene)?;
        self.device.check_size(size)?;
        let rest = &model.moments(MotionName::CameraOrbit, 1, size.aspect())?[0];
        let scene = Scene { mesh: &model.mesh, moment: rest.clone(), size };
        let measured = cases.iter().any(|case| matches!(case.work, Work::Preparation(..)));
        let (mut rounds, mut outcome) = (Rounds::default(), Outcome::default());
        let mut painter = None;
        // Before the first that counts comes one after which the driver has nothing to compile or to fetch any more.
        let warm_up = u32::from(measured && !self.warm.contains(&(technique, size)));
        self.warm.push((technique, size));
        let counting = if measured { self.effort.preparations } else { 1 };
        for number in 0..warm_up + counting {
            // The memory of the last one goes first.
            drop(painter.take());
            self.device.upload(&mut Uploads::default())?;
            let before = self.device.context.compile_time();
            self.device.runner.take_times();
            let start = std::time::Instant::now();
            let mut made = self.painter(&scene, &model, technique)?;
            let wall = start.elapsed();
            self.look();
            let wall_ms = milliseconds(wall.saturating_sub(self.device.context.compile_time() - before));
            let time = Time::new(&mut self.device, wall_ms);
            if number >= warm_up {
                rounds.add(vec![time]);
            }
            self.frame(&mut made, rest, 0, true)?;
            outcome.round(self.device.runner.read_image(made.image())?);
            painter = Some(made);
        }
        let Some(mut painter) = painter else { return Ok(()) };
        for case in cases {
            match case.work {
                Work::Frame(_, _, motion) => {
                    let result = self.frames(&mut painter, case, &model, technique, motion);
                    self.go_on(std::slice::from_ref(case), result)?;
                }
                _ => {
                    let figures = std::mem::take(&mut rounds).figures(false, false);
                    self.row(case, figures, std::mem::take(&mut outcome), Some(share_allowed(technique, case.size)));
                }
            }
        }
        Ok(())
    }

    pub(super) fn painter<'s>(
        &mut self,
        scene: &'s Scene<'s>,
        model: &Model,
        technique: TechniqueName,
    ) -> Result<Painter<'s>> {
        let quilt = self.quilt_params();
        let chosen = chosen(technique, quilt);
        Painter::new(&mut self.session, &mut self.device, scene, &model.paints, &chosen)
    }

    /// Draws a frame, and takes its time.
    pub(super) fn frame(
        &mut self,
        painter: &mut Painter<'_>,
        moment: &Moment,
        number: u32,
        fresh: bool,
    ) -> Result<Time> {
        let next = NextFrame { fresh, ..NextFrame::alone(moment, number) };
        let (_, time) = Time::of(&mut self.device, |device| {
            painter.advance(None, device, &next)?;
            painter.draw(device, Show::Painted)
        })?;
        Ok(time)
    }

    fn frames(
        &mut self,
        painter: &mut Painter<'_>,
        case: &Case,
        model: &Model,
        technique: TechniqueName,
        motion: MotionName,
    ) -> Result {
        let moments = model.moments(motion, self.effort.warm_up + self.effort.frames, case.size.aspect())?;
        let (mut rounds, mut outcome) = (Rounds::default(), Outcome::default());
        for _ in 0..self.effort.rounds {
            let mut times = Vec::with_capacity(moments.len());
            for (number, moment) in (0..).zip(&moments) {
                times.push(self.frame(painter, moment, number, motion.is_fresh(number))?);
            }
            self.look();
            rounds.add(times.split_off(self.effort.warm_up as usize));
            outcome.round(self.device.runner.read_image(painter.image())?);
        }
        self.row(
            case,
            rounds.figures(self.effort.sustained, false),
            outcome,
            Some(share_allowed(technique, case.size)),
        );
        Ok(())
    }

    pub(super) fn quilt_params(&self) -> QuiltParams {
        QuiltParams { seed: self.effort.seed, ..QuiltParams::default() }
    }

    pub(super) fn quilt(&mut self, problem: &Problem) -> Result<Quilt> {
        let mut uploads = Uploads::default();
        let stages = self.session.quilt_stages(&mut self.device, SearchFlag::Auto)?;
        let quilt = problem.prepare(&self.device.context, &mut uploads, &stages)?;
        self.device.upload(&mut uploads)?;
        Ok(quilt)
    }

    fn synthesis(&mut self, case: &Case) -> Result {
        let problem = Problem::of(case, self.quilt_params())?;
        let quilt = self.quilt(&problem)?;
        self.effort.synthesise(&mut self.device, &quilt)?;
        let blocks = quilt.read_records(&mut self.device.runner)?.len();
        let (mut rounds, mut outcome) = (Rounds::default(), Outcome::default());
        for _ in 0..self.effort.rounds {
            let (_, time) = Time::of(&mut self.device, |device| self.effort.synthesise(device, &quilt))?;
            self.look();
            rounds.add(vec![time.rate(blocks)]);
            outcome.round(self.device.runner.read_image(quilt.canvas())?);
        }
        if let Some(hash) = self.shared.oracle(case, &problem)? {
            outcome.must_be(&hash, "those of the CPU oracle");
        }
        self.row(case, rounds.figures(self.effort.sustained, true), outcome, None);
        Ok(())
    }

    fn throughput(&mut self, case: &Case, in_flight: u32) -> Result {
        let model = self.shared.model(SceneName::Head)?;
        let params = ImageParams { quilt: self.quilt_params(), ..ImageParams::default() };
        let stream = Stream::new(&mut self.session, &mut self.device, &model, case.size, &params)?;
        let moments = model.moments(MotionName::LightOrbit, self.effort.stream_frames, case.size.aspect())?;
        stream.run(&self.device, &moments[..in_flight as usize], in_flight)?;
        let (mut rounds, mut outcome) = (Rounds::default(), Outcome::default());
        for _ in 0..self.effort.rounds {
            let time = stream.run(&self.device, &moments, in_flight)?;
            self.look();
            rounds.add(vec![time.rate(1)]);
            outcome.round(stream.read(&mut self.device)?);
        }
        match &self.stream_hash {
            Some(hash) => outcome.must_be(hash, "those with another number of frames in flight"),
            None => self.stream_hash = Some(outcome.check().hash),
        }
        let share = share_allowed(TechniqueName::Image, case.size);
        self.row(case, rounds.figures(self.effort.sustained, true), outcome, Some(share));
        Ok(())
    }

    /// Takes note of how the device is, before anything else lets it idle.
    fn look(&mut self) {
        self.state = self.telemetry.as_ref().and_then(Reader::read);
    }

    /// Adds a row. `share` is that of pixels that may differ from the first device's.
    fn row(&mut self, case: &Case, figures: Figures, mut outcome: Outcome, share: Option<f64>) {
        let device = self.device.context.device_info();
        let whose = format!("{} (device {})", device.name, device.index);
        if share.is_some() {
            outcome.must_be_painted();
        }
        self.shared.references.compare(&case.id, &whose, &mut outcome, share);
        let (kind, technique, scene, motion) = match case.work {
            Work::Preparation(technique, scene) => (Kind::Preparation, Some(technique), Some(scene), None),
            Work::Frame(technique, scene, motion) => (Kind::Frame, Some(technique), Some(scene), Some(motion)),
            Work::Synthesis { .. } => (Kind::Synthesis, None, None, None),
            Work::Throughput { .. } => {
                let moving = Some(MotionName::LightOrbit);
                (Kind::Throughput, Some(TechniqueName::Image), Some(SceneName::Head), moving)
            }
        };
        let kind = if kind == Kind::Frame && self.effort.sustained { Kind::Sustained } else { kind };
        let in_flight = match case.work {
            Work::Throughput { in_flight } => Some(in_flight),
            _ => None,
        };
        let (unit, more_is_better) = match kind {
            Kind::Frame | Kind::Sustained | Kind::Preparation => ("ms", false),
            Kind::Synthesis => ("blocks/s", true),
            Kind::Throughput => ("frames/s", true),
        };
        self.measurements.push(Measurement {
            id: case.id(self.effort.sustained),
            kind,
            technique: technique.map(technique_name),
            scene: scene.map(|scene| scene.name().to_owned()),
            motion: motion.map(|motion| motion.name().to_owned()),
            size_px: [case.size.width, case.size.height],
            unit: unit.to_owned(),
            more_is_better,
            in_flight,
            gpu: figures.gpu,
            wall: figures.wall,
            round_p50: figures.round_p50,
            memory_bytes: self.device.context.allocated_bytes(),
            check: outcome.check(),
            telemetry: self.state.take(),
        });
        self.progress.step();
    }
}

impl Effort {
    /// One synthesis, in submissions of bounded work.
    pub(super) fn synthesise(&self, device: &mut Device, quilt: &Quilt) -> Result {
        for part in quilt.parts(PART_COMPARISONS) {
            device.runner.run(|recorder| {
                quilt.record_part(recorder, part, self.seed, 0);
                Ok(())
            })?;
        }
        Ok(())
    }
}

/// How the program paints where it is not told otherwise, frames keeping to those before them.
fn chosen(technique: TechniqueName, quilt: QuiltParams) -> Chosen {
    let technique = match technique {
        TechniqueName::Image => Technique::Image(Continuity::Carry(RepairParams::default())),
        TechniqueName::Object => Technique::Object(ObjectParams::default()),
        TechniqueName::Aligned => {
            let params = LevelParams::default();
            let quilt = QuiltParams { tileable: params.quilt.tileable, ..quilt };
            Technique::Aligned(LevelParams { quilt, ..params }, AlignedFrame::default())
        }
        TechniqueName::Dependent => Technique::Dependent(default_views(), VIEW_PX, DependentParams::default()),
    };
    Chosen { technique, quilt, search: SearchFlag::Auto, k: None, levels: false }
}

pub(super) fn milliseconds(time: std::time::Duration) -> f64 {
    time.as_secs_f64() * 1e3
}
