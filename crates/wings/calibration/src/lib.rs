//! Wing for kinematic calibration.
#![warn(missing_docs)]
mod base_geometry;
mod chain;
mod corrections;
mod fit;
mod folds;
mod measurement;
mod mistakes;
mod parameter;
mod pose_table;
mod start;

#[cfg(test)]
mod trial {
    use crate::base_geometry::geometric_base;
    use crate::chain::{Chain, Convention};
    use crate::fit::{Fitter, Noise};
    use crate::folds::{Candidate, error_on};
    use crate::measurement::Problem;
    use crate::parameter::ParameterGroup as G;
    use crate::pose_table::PoseTable;
    use crate::start::start;
    use std::path::Path;

    fn one(urdf: &str, csv: &str, convention: Convention) {
        let dir = "/work/shared/data/calibration/";
        let robot = rist::read_robot(Path::new(&format!("{dir}{urdf}")), &Default::default()).unwrap();
        let chain = Chain::new(&robot, robot.link_ids().last().unwrap(), convention).unwrap();
        let t0 = std::time::Instant::now();
        let table = PoseTable::read(Path::new(&format!("{dir}{csv}")), &robot, &chain.coordinates, &Default::default(), None).unwrap();
        let postures = table.postures(&Default::default()).unwrap();
        let problem = Problem::new(chain, table.kind, postures);
        println!("{csv} {:?} {} {:?}", table.kind, table.count(), table.notes);
        for what in [&[G::Frames][..], &[G::Frames, G::Zeros], &[G::Frames, G::Zeros, G::Geometry]] {
            let base = geometric_base(&robot, &problem, |p| what.contains(&p.group())).unwrap();
            println!("base {} grouped {} none {} gap {:.1e} {:.1e}", base.kept.len(), base.grouped.len(), base.without_effect.len(), base.smallest_kept, base.largest_dropped);
            let of_zeros: Vec<usize> = base.kept.iter().copied().filter(|&k| problem.parameters[k].group() != G::Geometry).collect();
            let first = start(&problem, &of_zeros, 40);
            println!("start {:?} {:?}", t0.elapsed(), error_on(&problem, &first, &(0..problem.postures.len()).collect::<Vec<_>>()));
            let rows: Vec<usize> = (0..problem.postures.len()).collect();
            let noise = Noise { length: 5e-3, angle: 5e-3 };
            let z = Fitter { problem: &problem, active: &of_zeros, prior: None, rows: &rows }.fit(&first, noise);
            let c = Candidate { problem: &problem, base: &base, active: &base.kept, may_hold: what.len() == 3 };
            let (fit, dev) = c.chosen(&z.unknowns, z.noise);
            println!("fit {:?} {:?} noise {:?} prior {:?} outliers {:?}", t0.elapsed(), error_on(&problem, &fit.unknowns, &rows), fit.noise, dev, rows.iter().filter(|r| !fit.used[**r]).collect::<Vec<_>>());
            println!("out {:?} {:?}", c.left_out(&z.unknowns, z.noise), t0.elapsed());
        }
    }

    #[test]
    fn ur10() { one("ur10_camera/ur10.urdf", "ur10_camera/poses.csv", Convention::Frames); }
    #[test]
    fn talos() { one("talos_contact/talos_left_arm.urdf", "talos_contact/points.csv", Convention::Frames); }
    #[test]
    fn tiago() { one("tiago_mocap/tiago_arm.urdf", "tiago_mocap/points.csv", Convention::Frames); }
}
