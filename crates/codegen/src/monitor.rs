//! The monitor of a generated C file. It estimates the external torque, contact and the load, with one call per cycle.
//!
//! The text is in online.c. The C code performs the operations of the crate `online` in the same order, and keeps its state in
//! a struct of the caller. The monitor calls the functions `momentum_and_rate`, `base_regressor` and `load_momentum_..` of the
//! same file, and reads the constant X of the file.

/// The numbers of a monitor, from an estimate and the logs that it was made from. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// Number n of joints.
    pub joints: usize,
    /// Number p of base parameters.
    pub parameters: usize,
    /// Name of the function of the load, such as `load_momentum_tool0`.
    pub load_function: String,
    /// Gain of the observer, 1/s.
    pub gain: f64,
    /// Rate of the control loop, Hz.
    pub rate: f64,
    /// For each joint, the ratio of two standard deviations of a mean of errors: with the autocorrelation of the errors, and for
    /// independent errors.
    pub load_factors: Vec<f64>,
    /// Threshold of contact, standard deviations.
    pub threshold: f64,
    /// The external torque of a joint is significant beyond this number of standard deviations.
    pub significant: f64,
    /// Contact ends after the torques have stayed below half of the threshold for this time, s.
    pub hold: f64,
    /// Six constants of each joint, in this order: standard deviation of the external torque without contact, at speed;
    /// additional standard deviation at standstill; dry friction that the model does not contain, at standstill; speed at which
    /// half of the two previous values remains; speed below which the sign of friction changes smoothly; standard deviation of
    /// the change of the external torque from cycle to cycle.
    pub bands: Vec<[f64; 6]>,
    /// Limit of the torque of each joint, N m (N); infinite where there is none.
    pub efforts: Vec<f64>,
    /// The columns of friction, in the order of the rows of `factor`.
    pub friction: Vec<FrictionColumn>,
    /// Base parameters with which the torque `predicted` of [`FrictionColumn::entry`] is computed.
    pub friction_base: Vec<f64>,
    /// A matrix G that factorises the covariance C of the parameters: C = G G'. G has one row for each parameter: the base
    /// parameters, then the friction parameters. The columns of G are called directions. If y is a row of the
    /// regressor, the predicted torque has the variance y C y' = |y G|^2.
    pub factor: Vec<Vec<f64>>,
    /// Number of directions, that is, of columns of the matrix `factor`.
    pub directions: usize,
    /// Standard deviation of each of the ten load parameters over all possible loads: the uncertainty before the first measured
    /// row.
    pub load_start: [f64; 10],
    /// Four constants of the decision whether a contact is a new load: time for which the contact must last, s; time at its
    /// beginning in which no rows are used, s; averaging time of the misfit, s; largest misfit of a load that explains the
    /// torques. Misfit: mean of m^2 / var(m), m: mean residual of a joint over the averaging time; 1 is expected.
    pub decision: [f64; 4],
    /// Averaging time for the ratio of the present noise to the noise of the logs, s.
    pub scale_memory: f64,
}

/// A column of friction: the torque of friction of `joint` is the sum of value * entry over its columns.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionColumn {
    /// Index of the joint.
    pub joint: usize,
    /// The entry of the column in a cycle, as a C expression of the arrays dq, ddq, tau, predicted and direction of the monitor.
    pub entry: String,
    /// The parameter, SI units.
    pub value: f64,
}

/// If a cycle comes later than this number of periods after the previous cycle, the state is out of date: the monitor starts
/// again.
const LONGEST_PERIODS: f64 = 5.0;

const SOURCE: &str = include_str!("online.c");

const HEADER: &str = "
/* ---- External torque, contact and load, one call a cycle ---- */

/* Parts of the answer of PREFIX_monitor_step: there is contact; it begins with this cycle; the load has changed; the state was not
   used (no number, or a period that is not positive or too long), and the observer starts again with the next cycle; a torque is
   at its limit, so its external torque is not known, and the load is estimated without it. */
#define UPPER_CONTACT 1
#define UPPER_BEGINS 2
#define UPPER_LOAD_CHANGED 4
#define UPPER_NOT_USED 8
#define UPPER_SATURATED 16

/* Least squares for the load, by rows. */
typedef struct {
    PREFIX_real triangle[10][10], right[10], shared[10][DIRECTIONS];
} PREFIX_payload;

/* The load in the frame of LOAD_FUNCTION: XX XY XZ YY YZ ZZ MX MY MZ M, their standard deviations, and whether the motion
   determines them. last_joint: the last joint with a significant external torque; this joint or a later one moves the
   touched link; -1: none. */
typedef struct {
    PREFIX_real parameters[10], sigma[10];
    int is_determined[10], last_joint;
    /* The rest is its own memory. */
    PREFIX_payload current, former;
    PREFIX_real inverse[10][10], age, misfit, misfit_of_one;
    int phase, has_load;
} PREFIX_load;

/* external: torque from outside, N m (N), with that of the load; beyond: without that of the load; limit: contact is said beyond
   it. The rest is its own memory. */
typedef struct {
    PREFIX_real external[LENGTH], beyond[LENGTH], limit[LENGTH];
    int is_contact;
    PREFIX_load load;
    PREFIX_real momentum[LENGTH], known[LENGTH], slow[LENGTH], before[LENGTH], change_square[LENGTH], quiet;
    PREFIX_real low[LENGTH], low_known[LENGTH], load_momentum[LENGTH][10], load_known[LENGTH][10], row[LENGTH][10], noise_variance[LENGTH], dry[LENGTH], mean[LENGTH], carried_mean[LENGTH];
    int has_started;
} PREFIX_monitor;

/* Starts a monitor: no contact and no load. */
void PREFIX_start(PREFIX_monitor *m);

/* Takes the measured state of a cycle: q, dq, torque of the motors tau, and the time since the cycle before, s. Made for RATE Hz. */
int PREFIX_monitor_step(PREFIX_monitor *m, const PREFIX_real q[LENGTH], const PREFIX_real dq[LENGTH], const PREFIX_real tau[LENGTH], PREFIX_real period);

/* The load that would explain the present contact, before it is decided whether the contact is a load: its parameters and their
   standard deviations. For a program that knows that a gripper has just closed. Returns 0 without contact, just after its
   beginning, and after the decision for a load; x and sigma are not written then. */
int PREFIX_load_candidate(const PREFIX_monitor *m, PREFIX_real x[10], PREFIX_real sigma[10]);
";

impl Monitor {
    /// The declarations and the definitions of the monitor, for the module with the name `prefix`.
    pub(crate) fn c(&self, prefix: &str) -> (String, String) {
        let put = |text: &str| {
            text.replace("CONSTANTS", &self.constants())
                .replace("LOAD_FUNCTION", &self.load_function)
                .replace("PREFIX_LOAD_MOMENTUM", &format!("{prefix}_{}", self.load_function))
                .replace("PREFIX", prefix)
                .replace("UPPER", &prefix.to_ascii_uppercase())
                .replace("LENGTH", &self.joints.to_string())
                .replace("COLUMNS", &self.parameters.to_string())
                .replace("DIRECTIONS", &self.directions.to_string())
                .replace("RATE", &format!("{}", self.rate))
        };
        (put(HEADER), put(SOURCE))
    }

    /// Whether a column of friction calls the macro `name`.
    pub(crate) fn friction_calls(&self, name: &str) -> bool {
        self.friction.iter().any(|column| column.entry.contains(&format!("{name}(")))
    }

    fn constants(&self) -> String {
        let [time, settling, memory, misfit] = self.decision;
        let numbers = [
            ("GAIN", "gain of the observer, 1/s", self.gain),
            ("THRESHOLD", "of contact, standard deviations", self.threshold),
            ("SIGNIFICANT", "for one joint, standard deviations", self.significant),
            ("HOLD", "s", self.hold),
            ("LONGEST_PERIOD", "s", LONGEST_PERIODS / self.rate),
            ("DECISION", "time of contact before it may be a load, s", time),
            ("SETTLING", "time at the beginning of contact that is not used, s", settling),
            ("MISFIT_MEMORY", "s", memory),
            ("LARGEST_MISFIT", "with which a load explains a contact", misfit),
            ("SCALE_MEMORY", "of the noise, s", self.scale_memory),
        ];
        let mut text: String = numbers
            .iter()
            .map(|(name, meaning, value)| format!("#define {name} ((real){value:?}) /* {meaning} */\n"))
            .collect();
        let names = ["noise", "low_speed", "dry", "low_speed_speed", "smooth_speed", "change_deviation"];
        for (k, name) in names.iter().enumerate() {
            text += &array(name, "N", self.bands.iter().map(|band| band[k]));
        }
        text += &array("load_factor", "N", self.load_factors.iter().copied());
        // Zero stands for no limit: C99 has no constant for an infinite number.
        let efforts = self.efforts.iter().map(|effort| if effort.is_finite() { *effort } else { 0.0 });
        text += &array("effort", "N", efforts);
        text += &array("load_start", "TEN", self.load_start.into_iter());
        text += &format!("static const real factor[{}][D] = {{\n", self.factor.len());
        for row in &self.factor {
            let row: Vec<String> = row.iter().map(|x| format!("(real){x:?}")).collect();
            text += &format!("    {{{}}},\n", row.join(", "));
        }
        text + "};\n" + &self.friction_columns()
    }

    /// The macros, constants and the function of the columns of friction. A robot without friction has one column of zeros, because
    /// C99 has no empty arrays.
    fn friction_columns(&self) -> String {
        let none = [FrictionColumn { joint: 0, entry: "0".to_string(), value: 0.0 }];
        let columns = if self.friction.is_empty() { &none } else { self.friction.as_slice() };
        let joints: Vec<String> = columns.iter().map(|column| column.joint.to_string()).collect();
        let mut text = format!("#define FRICTIONS {}\n", columns.len());
        text += &format!("static const int friction_joint[FRICTIONS] = {{{}}};\n", joints.join(", "));
        text += &array("friction_value", "FRICTIONS", columns.iter().map(|column| column.value));
        text += &array("friction_base", "COLUMNS", self.friction_base.iter().copied());
        text += FRICTION_HEAD;
        for (k, column) in columns.iter().enumerate() {
            text += &format!("    column[{k}] = {};\n", column.entry);
        }
        text + "}\n"
    }
}

const FRICTION_HEAD: &str = "
/* The columns of friction. predicted: torques without friction by the model; direction: of the velocities, -1 to 1. */
static void friction_columns(const real dq[N], const real ddq[N], const real tau[N], const real predicted[N], const real direction[N], real column[FRICTIONS])
{
    (void)dq, (void)ddq, (void)tau, (void)predicted, (void)direction;
";

/// The definition of a constant array.
fn array(name: &str, length: &str, values: impl Iterator<Item = f64>) -> String {
    let values: Vec<String> = values.map(|x| format!("(real){x:?}")).collect();
    format!("static const real {name}[{length}] = {{{}}};\n", values.join(", "))
}
