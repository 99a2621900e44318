//! Order of joints and standard parameters of URDF robots against an independent library.
//!
//! The tables hold, for each moving link, m mx my mz Ixx Ixy Iyy Ixz Iyz Izz about the origin of
//! its joint frame. They are not part of the repository: without them the test says so.

use std::io::Read;
use std::path::PathBuf;

fn shared() -> Option<PathBuf> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let folder = std::env::var_os("RIST_SHARED").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: ../shared absent");
    None
}

#[test]
fn standard_parameters_agree_in_the_joint_frames_of_the_file() {
    let Some(folder) = shared().map(|s| s.join("oracle")) else { return };
    // The library reads past mimic tags: the two fingers of the panda are coordinates there.
    let options = robot::format::UrdfOptions { mimic: robot::format::Mimic::Independent };
    for name in ["baxter", "double_pendulum", "panda", "solo12", "ur5"] {
        let robot =
            robot::format::read_with(&folder.join(format!("{name}.urdf")), options).unwrap_or_else(|e| panic!("{e}"));
        let mut text = String::new();
        let file = std::fs::File::open(folder.join(format!("{name}.csv.gz"))).unwrap();
        flate2::read::GzDecoder::new(file).read_to_string(&mut text).unwrap();
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().unwrap().split(',').collect();
        let row: Vec<f64> = lines.next().unwrap().split(',').map(|x| x.parse().unwrap()).collect();

        let joints: Vec<&str> = head.iter().filter_map(|h| h.strip_prefix("q_")).collect();
        let ours: Vec<&str> = robot.coordinates.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(ours, joints, "{name}");

        for link in &robot.links {
            let about_joint = robot::transform_inertial(&link.inertial.unwrap_or_default(), &link.file_frame.inverse());
            let [xx, xy, xz, yy, yz, zz, mx, my, mz, m] = about_joint;
            let pairs = [
                ("m", m),
                ("mx", mx),
                ("my", my),
                ("mz", mz),
                ("Ixx", xx),
                ("Ixy", xy),
                ("Iyy", yy),
                ("Ixz", xz),
                ("Iyz", yz),
                ("Izz", zz),
            ];
            for (parameter, value) in pairs {
                let column = format!("X_{}_{parameter}", link.joint.name);
                let k = head.iter().position(|h| *h == column).unwrap_or_else(|| panic!("{column}"));
                // Angles of fixed joints are snapped by up to 5e-12 here and not there.
                assert!((value - row[k]).abs() <= 1e-10, "{name} {column}: {value} {}", row[k]);
            }
        }
    }
}
