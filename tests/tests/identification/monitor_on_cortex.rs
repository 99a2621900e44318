//! Runs the generated monitor (external torque, contact, load) of an arm with seven joints on a Cortex-M7 that QEMU emulates.
//! Checks the number of instructions and the memory of one cycle.
//!
//! The test needs `arm-none-eabi-gcc` with newlib and `qemu-system-arm` (Debian: gcc-arm-none-eabi, libnewlib-arm-none-eabi,
//! qemu-system-arm). Without them it prints a note and is skipped.

use std::path::Path;
use std::process::Command;

use rist::Model;
use rist::describe::source::{GeneratedSource, IdentifiedValues, Language};
use rist::request::{GenerateRequest, IdentifyRequest};
use tests::on_robot::{Carried, Push, Scene};
use tests::program::{done, folder};

/// C text of the firmware: a vector table, and a program that runs the monitor over a table of states. QEMU runs one
/// instruction in a nanosecond, so one tick of the system timer (25 MHz) is 40 instructions. The stack is first filled with a
/// pattern, so that the memory that a cycle overwrites can be measured.
const FIRMWARE: &str = r#"
#include "arm.h"
#include "states.h"

extern unsigned stack_top[];
int main(void);
void reset(void);
__attribute__((section(".vectors"), used)) static void *const vectors[] = {stack_top, (void *)reset, (void *)reset, (void *)reset};

#define SYST ((volatile unsigned *)0xE000E010)
#define STACK_WORDS 8192
static ROBOT_monitor monitor;

static void say(const char *text)
{
    register unsigned operation __asm__("r0") = 4;
    register const char *argument __asm__("r1") = text;
    __asm__ volatile("bkpt 0xab" : "+r"(operation) : "r"(argument) : "memory");
}

static void say_number(unsigned x)
{
    char text[12];
    int k = 11;
    text[k] = 0;
    do
        text[--k] = (char)('0' + x % 10);
    while (x /= 10);
    say(&text[k]);
    say(" ");
}

void reset(void)
{
    *(volatile unsigned *)0xE000ED88 |= 0xfu << 20; /* The floating-point unit. */
    __asm__ volatile("dsb\nisb");
    main();
    register unsigned operation __asm__("r0") = 0x18;
    register unsigned argument __asm__("r1") = 0x20026;
    __asm__ volatile("bkpt 0xab" : : "r"(operation), "r"(argument));
    for (;;) {
    }
}

int main(void)
{
    unsigned least = ~0u, most = 0, before, taken, k, seen = 0;
    volatile unsigned *const bottom = stack_top - STACK_WORDS;
    for (k = 0; k < STACK_WORDS - 256; k++)
        bottom[k] = 0xdeadbeef;
    SYST[1] = 0xffffff;
    SYST[2] = 0;
    SYST[0] = 5;
    ROBOT_start(&monitor);
    for (k = 0; k < STATES; k++) {
        before = SYST[2];
        seen |= (unsigned)ROBOT_monitor_step(&monitor, states[k], states[k] + JOINTS, states[k] + 2 * JOINTS, PERIOD);
        taken = (before - SYST[2]) & 0xffffff;
        if (k > 0) {
            least = taken < least ? taken : least;
            most = taken > most ? taken : most;
        }
    }
    for (k = 0; k < STACK_WORDS && bottom[k] == 0xdeadbeef; k++) {
    }
    say_number(40 * least);
    say_number(40 * most);
    say_number(4 * (STACK_WORDS - k));
    say_number(sizeof monitor);
    say_number(seen);
    return 0;
}
"#;

const LINKER: &str = "
ENTRY(reset)
MEMORY { FLASH (rx) : ORIGIN = 0, LENGTH = 4M  RAM (rwx) : ORIGIN = 0x20000000, LENGTH = 256K }
stack_top = 0x20040000;
SECTIONS {
    .text : { KEEP(*(.vectors)) *(.text*) *(.rodata*) } > FLASH
    .ARM.exidx : { *(.ARM.exidx*) } > FLASH
    .data : { *(.data*) } > RAM
    .bss : { *(.bss*) *(COMMON) } > RAM
}
";

/// Largest allowed numbers of instructions and of bytes of memory of a cycle: for a control loop of 1 kHz on a processor of
/// about 200 MHz that also has other tasks.
const MOST_INSTRUCTIONS: u32 = 50_000;
const MOST_BYTES: u32 = 16 * 1024;

#[test]
fn a_cycle_fits_a_microcontroller() {
    let is_there = |program: &str| Command::new(program).arg("--version").output().is_ok();
    if !["arm-none-eabi-gcc", "qemu-system-arm"].into_iter().all(is_there) {
        println!("skipped: arm-none-eabi-gcc and qemu-system-arm are not there");
        return;
    }
    let model = Model::read(tests::model_path("kuka_lwr.yaml")).unwrap();
    let n = model.regressor().coordinates().len();
    let standard = model.parameters.values(&tests::random::Random(4).physical_parameters(&model.robot));
    let quiet = Scene {
        model: &model,
        x: standard,
        friction: vec![[2.0, 1.0, 0.1]; n],
        seed: 3,
        seconds: 40.0,
        rate: 500.0,
        noise: 0.1,
        speed_noise: 1e-3,
        amplitude: 1.0,
        pushes: Vec::new(),
        loads: Vec::new(),
    };
    let log = quiet.source();
    let mut request = IdentifyRequest::default();
    request.samples.covariance = true;
    let estimate = rist::identify(&model, std::slice::from_ref(&log), &request).unwrap().estimate;
    let functions = ["observer", "payload"].map(String::from);
    let request = GenerateRequest { functions: functions.to_vec(), rate: 500.0, ..GenerateRequest::default() };
    let mut values = IdentifiedValues::of(&model, &estimate).unwrap();
    let logs = std::slice::from_ref(&log);
    values.monitor = Some(rist::replay::monitor(&model, (Path::new("e.yaml"), &estimate), logs, &request).unwrap());
    let language = Language::C { header: "arm.h".into() };
    let source = rist::generate(&model.robot, &functions, &language, "this test", Some(&values), &[], false).unwrap();

    let link = model.robot.links.last().unwrap().name.clone();
    let load = rist::KnownLoad { link, mass: 2.0, centre_of_mass: [0.0, 0.05, 0.1], inertia: Default::default() };
    let push = Push { link: 4, from: 0.5, to: 0.7, force: [40.0, 40.0, 0.0], largest: None };
    let loads = vec![Carried { from: 1.0, to: 9.0, load }];
    let (busy, _) = Scene { seconds: 4.0, seed: 9, pushes: vec![push], loads, ..quiet }.log();
    let said = run_on_cortex(&model.robot.name, source, &busy);
    let numbers: Vec<u32> = said.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [least, most, stack, monitor, seen] = numbers[..] else { panic!("{said}") };
    println!("{least} to {most} instructions a cycle, {stack} bytes of stack, {monitor} bytes of state");
    // The status bits seen are: contact, start of a contact, and change of the load.
    assert_eq!(seen, 1 + 2 + 4, "{said}");
    assert!(most <= MOST_INSTRUCTIONS && stack + monitor <= MOST_BYTES, "{said}");
    // The number of instructions varies by less than 5 % between cycles.
    assert!(f64::from(most) < 1.05 * f64::from(least), "{said}");
}

/// Compiles the source together with a table of the rows of a log, and runs the program in QEMU. Returns the output of the
/// program.
fn run_on_cortex(prefix: &str, source: GeneratedSource, log: &logs::Log) -> String {
    let n = log.q.len();
    let rows: Vec<String> = (0..log.t.len())
        .map(|r| {
            let series = log.q.iter().chain(log.dq.as_ref().unwrap()).chain(&log.effort);
            format!("    {{{}}},\n", series.map(|x| format!("{:e}f", x[r])).collect::<Vec<_>>().join(", "))
        })
        .collect();
    let here = folder("monitor_on_cortex");
    let states = format!(
        "#define STATES {}\n#define JOINTS {n}\n#define PERIOD 0.002f\nstatic const float states[STATES][3 * JOINTS] = {{\n{}}};\n",
        rows.len(),
        rows.concat()
    );
    let files = [
        ("arm.c", source.text),
        ("arm.h", source.header.unwrap()),
        ("states.h", states),
        ("firmware.c", FIRMWARE.replace("ROBOT", prefix)),
        ("firmware.ld", LINKER.to_string()),
    ];
    files.iter().for_each(|(name, text)| std::fs::write(here.join(name), text).unwrap());
    let real = format!("-D{}_REAL=float", prefix.to_ascii_uppercase());
    let target = format!("-std=c99 -O2 -mcpu=cortex-m7 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard {real}");
    done(&here, "arm-none-eabi-gcc", &format!("{target} -Wall -Wextra -Wdouble-promotion -Werror -c arm.c -o arm.o"));
    let linked = "-nostartfiles -T firmware.ld firmware.c arm.o -lm -lc -o firmware.elf";
    done(&here, "arm-none-eabi-gcc", &format!("{} {linked}", target.replace("-std=c99", "-std=gnu99")));

    // The object file calls no function for allocation, abort, or arithmetic of doubles in software.
    let symbols = Command::new("arm-none-eabi-nm").args(["-u", "arm.o"]).current_dir(&here).output().unwrap();
    let symbols = String::from_utf8(symbols.stdout).unwrap();
    let undefined: Vec<&str> = symbols.split_whitespace().filter(|word| *word != "U").collect();
    let allowed = ["sqrtf", "memcpy", "memset"];
    assert!(undefined.iter().all(|name| allowed.contains(name)), "{undefined:?}");

    let machine = "-M mps2-an500 -nographic -monitor none -serial none -icount shift=0 -semihosting-config enable=on,target=native";
    let run = Command::new("qemu-system-arm")
        .args(machine.split(' '))
        .args(["-kernel", "firmware.elf"])
        .current_dir(&here)
        .output()
        .unwrap();
    String::from_utf8_lossy(&run.stdout).into_owned() + &String::from_utf8_lossy(&run.stderr)
}
