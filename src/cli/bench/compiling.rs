//! What the driver compiles, and how long it takes: apart from all that is measured later.

use super::catalogue::{technique_name, Case, MotionName, SceneName, Work};
use super::rounds::Time;
use super::subject::{milliseconds, Subject};
use super::synthesis::Problem;
use crate::cli::failure::Result;
use crate::cli::painter::Scene;
use crate::cli::techniques::TechniqueName;
use crate::cli::values::Size;

/// Side of the pictures with which pipelines are compiled.
const SMALL: Size = Size { width: 128, height: 128 };

impl Subject<'_> {
    /// Compiles what the cases need, in small pictures, so that no measurement has any of it. What cannot be compiled
    /// will fail again where it is measured, and is told there.
    ///
    /// # Errors
    /// What the device failed at when it was lost or stuck.
    pub fn compile(&mut self, cases: &[Case]) -> Result {
        let mut techniques = Vec::new();
        let mut synthesis = false;
        for case in cases {
            let technique = match case.work {
                Work::Preparation(technique, _) | Work::Frame(technique, ..) => technique,
                Work::Throughput { .. } => TechniqueName::Image,
                Work::Synthesis { .. } => {
                    synthesis = true;
                    continue;
                }
            };
            if !techniques.contains(&technique) {
                techniques.push(technique);
            }
        }
        if synthesis {
            let ms = self.compile_synthesis();
            self.compiled("synthesis".to_owned(), ms)?;
        }
        for technique in techniques {
            let ms = self.compile_technique(technique);
            self.compiled(technique_name(technique), ms)?;
        }
        Ok(())
    }

    fn compiled(&mut self, name: String, ms: Result<f64>) -> Result {
        match ms {
            Ok(ms) => drop(self.compile_ms.insert(name, ms)),
            Err(failure) => self.if_alive(failure)?,
        }
        Ok(())
    }

    fn compile_synthesis(&mut self) -> Result<f64> {
        let before = self.device.context.compile_time();
        let mut late_ms = 0.0;
        for guided in [false, true] {
            let case = Case { id: String::new(), work: Work::Synthesis { guided }, size: SMALL };
            let problem = Problem::of(&case, self.quilt_params())?;
            let quilt = self.quilt(&problem)?;
            let (_, first) = Time::of(&mut self.device, |device| self.effort.synthesise(device, &quilt))?;
            let (_, second) = Time::of(&mut self.device, |device| self.effort.synthesise(device, &quilt))?;
            late_ms += (first.wall_ms - second.wall_ms).max(0.0);
        }
        Ok(milliseconds(self.device.context.compile_time() - before) + late_ms)
    }

    fn compile_technique(&mut self, technique: TechniqueName) -> Result<f64> {
        let model = self.shared.model(SceneName::Head)?;
        let moments = model.moments(MotionName::CameraOrbit, 3, 1.0)?;
        let scene = Scene { mesh: &model.mesh, moment: moments[0].clone(), size: SMALL };
        let before = self.device.context.compile_time();
        let mut painter = self.painter(&scene, &model, technique)?;
        let mut late_ms = 0.0;
        // A first frame, and one that goes on from another.
        for numbers in [[0, 0], [1, 2]] {
            let [first, second] =
                numbers.map(|number| self.frame(&mut painter, &moments[number], number as u32, number == 0));
            late_ms += (first?.wall_ms - second?.wall_ms).max(0.0);
        }
        Ok(milliseconds(self.device.context.compile_time() - before) + late_ms)
    }
}
