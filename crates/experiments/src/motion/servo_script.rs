//! Writes a motion as URScript, with one `servoj` command per sample [Universal Robots, The URScript Programming Language].
//!
//! The program moves to the first pose, follows the samples at their sample time with a look-ahead of 0.1 s and a gain of 300
//! (the controller's defaults), and stops.

use std::fmt::Write;

use crate::motion::reference_motion::Reference;

/// Text of a URScript program that plays the motion. The robot has six joints, in the order of the coordinates.
pub fn servo_script(reference: &Reference) -> String {
    let pose = |r: usize| {
        let cells: Vec<String> = reference.q.iter().map(|q| format!("{:.9}", q[r])).collect();
        format!("[{}]", cells.join(", "))
    };
    let samples = reference.q.first().map_or(0, Vec::len);
    let mut text =
        String::from("# Not tried on a controller: run it in the simulator first, then slowly.\ndef rist_motion():\n");
    if samples > 0 {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  movej({}, a=0.5, v=0.3)", pose(0));
    }
    for r in 0..samples {
        let _ = writeln!(text, "  servoj({}, 0, 0, {:?}, 0.1, 300)", pose(r), reference.sample_time);
    }
    text.push_str("  stopj(2.0)\nend\nrist_motion()\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_a_sample_between_start_and_stop() {
        let q = (0..6).map(|k| vec![0.1 * f64::from(k), 0.2]).collect();
        let reference = Reference { sample_time: 0.008, q, ..Reference::default() };
        let text = servo_script(&reference);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 8);
        assert!(lines[0].starts_with("# Not tried on a controller"));
        assert!(lines[2].starts_with("  movej([0.000000000, 0.100000000, "));
        assert_eq!(lines[4], format!("  servoj([{}], 0, 0, 0.008, 0.1, 300)", ["0.200000000"; 6].join(", ")));
    }
}
