"""Generated Rust and C beside casadi's C in its best form and Pinocchio's C++, of the same robot in one process: nanoseconds
a call, the best of 60 turns.

    cargo build --release -p cli
    pip install casadi pin numpy
    python docs/how-to/generated_beside_casadi.py ROBOT.urdf [--ways]

casadi's functions are in its own symbols, base parameters as inputs and all others structurally zero, with common
subexpressions taken out: the regressor row by row, from the wrench of each body per unit of a parameter and how each joint
moves the body; the torques by a Newton-Euler recursion; the inertia matrix by composite bodies, upper triangle. Only non-zeros
are written, by either side. Each compiler that is there, gcc and the newest clang, compiles in several ways, of which the best
counts; once with the library's sine and once with that of rist's C. Rust is `rist generate` with -C target-cpu=native, compiled
in several ways too. Pinocchio's functions are those of its headers, with all standard columns and dense results, which is what it
has: computeJointTorqueRegressor, rnea, crba and computeRNEADerivatives, by g++ and by clang++. Revolute and prismatic joints
alone; needs gcc, objcopy and rustc; Pinocchio by a compiler takes it a minute, and is left out where there is no g++.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import casadi as ca
import numpy as np
import pinocchio as pin

urdf = pathlib.Path(sys.argv[1]).resolve()
rist = pathlib.Path(__file__).resolve().parents[2] / "target/release/rist"
here = pathlib.Path(tempfile.mkdtemp())
model = pin.buildModelFromUrdf(str(urdf))
data, random = model.createData(), np.random.default_rng(1)
n, links = model.nv, model.njoints - 1
if model.nq != n:
    sys.exit(f"{urdf}: a joint without limits or with several degrees of freedom; make it revolute first")


def state():
    return random.uniform(-3, 3, n), random.uniform(-2, 2, n), random.uniform(-5, 5, n)


# Columns that the ones before do not give: the base parameters stand for them.
rows = [pin.computeJointTorqueRegressor(model, data, *state()) for _ in range(60 + 40 * links // n)]
rows = np.vstack(rows)
seen = np.flatnonzero(np.linalg.norm(rows, axis=0) > 1e-9)
diagonal = np.abs(np.diag(np.linalg.qr(rows[:, seen], mode="r")))
base = [int(c) for c, r in zip(seen, diagonal) if r > 1e-8 * diagonal.max()]


def sparse(x):
    """Zeros and ones of a rotation are none that rounding made."""
    if isinstance(x, np.ndarray):
        x = np.where(np.abs(x) < 1e-10, 0.0, np.where(np.abs(np.abs(x) - 1) < 1e-10, np.sign(x), x))
    return ca.sparsify(ca.SX(x))


def cross(a, b):
    return sparse(ca.vertcat(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


def turned(axis, q):
    """The rotation by q about an axis."""
    s, c, place = ca.sin(q), ca.cos(q), int(np.argmax(np.abs(axis)))
    if np.count_nonzero(np.abs(axis) > 1e-10) > 1:
        skew = sparse(np.cross(np.eye(3), -axis))
        return sparse(ca.SX.eye(3) + s * skew + (1 - c) * ca.mtimes(skew, skew))
    u, v, turn = (place + 1) % 3, (place + 2) % 3, ca.SX.eye(3)
    turn[u, u], turn[v, v], turn[u, v], turn[v, u] = c, c, -axis[place] * s, axis[place] * s
    return sparse(turn)


q, dq, ddq, x = (ca.SX.sym(name, size) for name, size in [("q", n), ("dq", n), ("ddq", n), ("x", len(base))])
standard = [ca.SX(1, 1) for _ in range(10 * links)]
for k, c in enumerate(base):
    standard[c] = x[k]

zero = ca.SX(3, 1)
w, dw, dv = ([zero] * (links + 1) for _ in range(3))
dv[0] = sparse(-model.gravity.linear)
turn, place, axes, force, moment = ([None] * (links + 1) for _ in range(5))
for j in range(1, links + 1):
    joint, parent = model.joints[j], model.parents[j]
    i, name = joint.idx_v, joint.shortname().replace("JointModel", "")
    axis = np.eye(3)["XYZ".index(name[-1])] if len(name) == 2 else np.array(joint.extract().axis)
    slides, axes[j] = name[0] == "P", sparse(axis)
    fixed, origin = sparse(model.jointPlacements[j].rotation), sparse(model.jointPlacements[j].translation)
    turn[j] = fixed if slides else sparse(ca.mtimes(fixed, turned(axis, q[i])))
    place[j] = sparse(origin + ca.mtimes(fixed, axes[j] * q[i])) if slides else origin
    back = turn[j].T
    w[j], dw[j] = ca.mtimes(back, w[parent]), ca.mtimes(back, dw[parent])
    at = dv[parent] + cross(dw[parent], place[j]) + cross(w[parent], cross(w[parent], place[j]))
    dv[j] = ca.mtimes(back, at)
    if slides:
        dv[j] = dv[j] + axes[j] * ddq[i] + 2 * cross(w[j], axes[j] * dq[i])
    else:
        dw[j] = dw[j] + axes[j] * ddq[i] + cross(w[j], axes[j] * dq[i])
        w[j] = w[j] + axes[j] * dq[i]
    w[j], dw[j], dv[j] = sparse(w[j]), sparse(dw[j]), sparse(dv[j])
    mass, mx, my, mz, xx, xy, yy, xz, yz, zz = standard[10 * (j - 1) : 10 * j]
    first = sparse(ca.vertcat(mx, my, mz))
    inertia = sparse(ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz)))
    force[j] = sparse(mass * dv[j] + cross(dw[j], first) + cross(w[j], cross(w[j], first)))
    moment[j] = sparse(ca.mtimes(inertia, dw[j]) + cross(w[j], ca.mtimes(inertia, w[j])) + cross(first, dv[j]))
tau = ca.SX(n, 1)
for j in range(links, 0, -1):
    slides = model.joints[j].shortname().replace("JointModel", "")[0] == "P"
    tau[model.joints[j].idx_v] = ca.dot(ca.densify(axes[j]), ca.densify(force[j] if slides else moment[j]))
    parent = model.parents[j]
    if parent:
        carried = ca.mtimes(turn[j], force[j])
        force[parent] += carried
        moment[parent] += ca.mtimes(turn[j], moment[j]) + cross(place[j], carried)



def matrix(rows):
    return sparse(ca.vertcat(*(ca.horzcat(*row) for row in rows)))


def skew(a):
    return matrix([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def by_inertia(a):
    """I a = by_inertia(a) (xx, xy, yy, xz, yz, zz)."""
    return matrix([[a[0], a[1], 0, a[2], 0, 0], [0, a[0], a[1], 0, a[2], 0], [0, 0, 0, a[0], a[1], a[2]]])


def dot(a, b):
    return ca.dot(ca.densify(a), ca.densify(b))


def slides(j):
    return model.joints[j].shortname().replace("JointModel", "")[0] == "P"


# Row i of body j's columns: the wrench that moves it per unit of a parameter, times how joint i moves it.
regressor, moves = ca.SX(n, 10 * links), [{} for _ in range(links + 1)]
for j in range(1, links + 1):
    for i, (angular, linear) in moves[model.parents[j]].items():
        carried = sparse(ca.mtimes(turn[j].T, linear + cross(angular, place[j])))
        moves[j][i] = (sparse(ca.mtimes(turn[j].T, angular)), carried)
    moves[j][j] = (zero, axes[j]) if slides(j) else (axes[j], zero)
    of_first = sparse(skew(dw[j]) + ca.mtimes(skew(w[j]), skew(w[j])))
    of_inertia = sparse(by_inertia(dw[j]) + ca.mtimes(skew(w[j]), by_inertia(w[j])))
    for i, (angular, linear) in moves[j].items():
        first = ca.mtimes(of_first.T, linear) + cross(dv[j], angular)
        row = ca.horzcat(dot(linear, dv[j]), ca.densify(first).T, ca.densify(ca.mtimes(of_inertia.T, angular)).T)
        regressor[model.joints[i].idx_v, 10 * (j - 1) : 10 * j] = row
regressor = ca.sparsify(regressor[:, base])

# Composite bodies: mass, first moments and inertia of all that a joint carries, in its frame.
mass, first, inertia = ([None] * (links + 1) for _ in range(3))
for j in range(1, links + 1):
    m, mx, my, mz, xx, xy, yy, xz, yz, zz = standard[10 * (j - 1) : 10 * j]
    mass[j], first[j] = m, sparse(ca.vertcat(mx, my, mz))
    inertia[j] = matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
inertia_matrix = ca.SX(n, n)
for j in range(links, 0, -1):
    f = sparse(mass[j] * axes[j]) if slides(j) else cross(axes[j], first[j])
    about = cross(first[j], axes[j]) if slides(j) else sparse(ca.mtimes(inertia[j], axes[j]))
    k = j
    while k:
        i, column = sorted((model.joints[k].idx_v, model.joints[j].idx_v))
        inertia_matrix[i, column] = dot(axes[k], f if slides(k) else about)
        f = sparse(ca.mtimes(turn[k], f))
        about = sparse(ca.mtimes(turn[k], about) + cross(place[k], f))
        k = model.parents[k]
    parent = model.parents[j]
    if parent:
        h, p = sparse(ca.mtimes(turn[j], first[j])), place[j]
        both = ca.mtimes(skew(p), skew(h))
        shifted = -both - both.T - mass[j] * ca.mtimes(skew(p), skew(p))
        inertia[parent] = sparse(inertia[parent] + ca.mtimes(ca.mtimes(turn[j], inertia[j]), turn[j].T) + shifted)
        first[parent] = sparse(first[parent] + h + mass[j] * p)
        mass[parent] = mass[parent] + mass[j]
inertia_matrix = ca.sparsify(inertia_matrix)

slopes = [ca.jacobian(tau, q), ca.jacobian(tau, dq)]
best = {"cse": True}
functions = {
    "base_regressor": ca.Function("base_regressor", [q, dq, ddq], [regressor], best),
    "inverse_dynamics": ca.Function("inverse_dynamics", [q, dq, ddq, x], [ca.densify(tau)], best),
    "inertia_matrix": ca.Function("inertia_matrix", [q, x], [inertia_matrix], best),
    "derivatives": ca.Function("derivatives", [q, dq, ddq, x], [ca.horzcat(*slopes)], best),
}
at = state()
difference = pin.computeJointTorqueRegressor(model, data, *at)[:, base] - np.array(functions["base_regressor"](*at))
values = random.uniform(0, 1, len(base))
by_acceleration = ca.Function("by_acceleration", [q, x], [ca.triu(ca.jacobian(tau, ddq))])
difference = max(
    abs(difference).max(),
    abs(np.array(functions["inertia_matrix"](at[0], values) - by_acceleration(at[0], values))).max(),
)
code = ca.CodeGenerator("robot.c")
for function in functions.values():
    code.add(function)
code.generate(f"{here}/")


def run(*words):
    subprocess.run(words, cwd=here, check=True)


names = "inverse-dynamics,inertia-matrix,inverse-dynamics-derivatives"
options = [urdf, "--rotor-inertia", "none", "--functions", names, "--quiet", "--out"]
run(rist, "generate", *options, "arm.rs")
run(rist, "generate", *options, "arm.c", "--language", "c")

# The sine of rist's C in the place of the library's.
ours = (here / "arm.c").read_text()
fused = ours[ours.index("/* a b + c: rounded once") : ours.index("#define MUL_ADD")]
sine = ours[ours.index("static inline void sin_cos_of_double") : ours.index("/* Within 1e-7 for")]
(here / "robot_sine.c").write_text(f"""#include <math.h>
#include <stdint.h>
{fused}{sine}
static inline double sine_of(double x) {{ double s, c; sin_cos_of_double(x, &s, &c); return s; }}
static inline double cosine_of(double x) {{ double s, c; sin_cos_of_double(x, &s, &c); return c; }}
#define sin sine_of
#define cos cosine_of
#include "robot.c"
""")

newest = next((clang for clang in [f"clang-{k}" for k in range(30, 14, -1)] + ["clang"] if shutil.which(clang)), None)
gcc = ["gcc " + flags for flags in ["-O3", "-O3 -fno-tree-slp-vectorize", "-O2 -fno-tree-slp-vectorize"]]
clang = [f"{newest} -O3", f"{newest} -O3 -fno-slp-vectorize"] if newest else []


def compiled(way, source, prefix, symbols):
    """An object whose functions are called prefix_NAME."""
    run(*way.split(), "-march=native", "-c", source, "-o", f"{prefix}.o")
    run("objcopy", *(f"--redefine-sym={symbol}={prefix}_{name}" for symbol, name in symbols), f"{prefix}.o")
    run("objcopy", *(f"--keep-global-symbol={prefix}_{name}" for _, name in symbols), f"{prefix}.o")
    return prefix


plain = [(name, name) for name in functions]
ours_too = [
    compiled(way, source, f"{source.removesuffix('.c')}{k}", plain)
    for source in ("robot.c", "robot_sine.c")
    for k, way in enumerate(gcc + clang)
]
with_library, with_ours = ours_too[: len(ours_too) // 2], ours_too[len(ours_too) // 2 :]
stem = re.search(r"(\w+)_real;", (here / "arm.h").read_text())[1]
suffixes = ["base_regressor_non_zeros", "inverse_dynamics", "inertia_matrix_non_zeros", "inverse_dynamics_derivatives"]
named = [(f"{stem}_{suffix}", name) for suffix, name in zip(suffixes, functions)]
generated_c = [compiled(way, "arm.c", f"arm{k}", named) for k, way in enumerate(gcc + clang)]

# Pinocchio, from its headers: the library that comes along was compiled by somebody else's compiler.
prefix = next((p for p in pathlib.Path(pin.__file__).parents if (p / "include/pinocchio").is_dir()), None)
eigen = pathlib.Path(ca.__file__).parent / "include/eigen3"
by = {"g++": "g++", "clang++": newest.replace("clang", "clang++") if newest else "clang++"}
by = {name: compiler for name, compiler in by.items() if shutil.which(compiler)} if prefix and eigen.is_dir() else {}
model.saveToText(str(here / "model.txt"))
(here / "peer.cpp").write_text(f"""
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/serialization.hpp>
using namespace pinocchio;
static Model read() {{ Model m; m.loadFromText("{here}/model.txt"); return m; }}
static Model& model() {{ static Model m = read(); return m; }}
static Data& data() {{ static Data d(model()); return d; }}
static Eigen::VectorXd of(const double* x) {{ return Eigen::Map<const Eigen::VectorXd>(x, {n}); }}
static Eigen::VectorXd q[64], v[64], a[64];
extern "C" void state(int s, const double* x, const double* dx, const double* ddx) {{
    q[s] = of(x), v[s] = of(dx), a[s] = of(ddx), data();
}}
extern "C" void base_regressor(int s) {{ computeJointTorqueRegressor(model(), data(), q[s], v[s], a[s]); }}
extern "C" void inverse_dynamics(int s) {{ rnea(model(), data(), q[s], v[s], a[s]); }}
extern "C" void inertia_matrix(int s) {{ crba(model(), data(), q[s], Convention::LOCAL); }}
extern "C" void derivatives(int s) {{ computeRNEADerivatives(model(), data(), q[s], v[s], a[s]); }}
""")
peers = []
for k, (name, compiler) in enumerate(by.items()):
    # As Pinocchio's own configuration for cmake has them.
    boost = ["MPL_LIMIT_LIST_SIZE=30", "MPL_LIMIT_VECTOR_SIZE=30", "MPL_CFG_NO_PREPROCESSED_HEADERS", "FUSION_INVOKE_MAX_ARITY=12"]
    includes = [f"-I{prefix}/include", f"-I{eigen}", *(f"-DBOOST_{word}" for word in boost)]
    includes += ["-DNDEBUG", "-std=c++17", "-w", "-fPIC", "-shared"]
    libraries = [f"-L{prefix}/lib", "-lboost_serialization", f"-Wl,-rpath,{prefix}/lib", "-Wl,-Bsymbolic"]
    run(compiler, "-O3", "-march=native", *includes, "peer.cpp", "-o", f"peer{k}.so", *libraries)
    peers.append(f"peer{k}")

source = (here / "arm.rs").read_text()
p = int(re.search(r"PARAMETERS: \[&str; (\d+)\]", source)[1])
entries = int(re.search(r"NON_ZEROS: \[\(usize, usize\); (\d+)\]", source)[1])
rust = [f"rust{k}" for k in range(3)]
library = f"""
#[allow(dead_code)]
mod arm;
type V = [f64; {n}];
#[unsafe(no_mangle)]
pub extern "C" fn WAY_base_regressor(q: &V, dq: &V, ddq: &V, y: &mut [f64; {entries}]) {{
    arm::base_regressor_non_zeros(q, dq, ddq, y)
}}
#[unsafe(no_mangle)]
pub extern "C" fn WAY_inverse_dynamics(q: &V, dq: &V, ddq: &V, x: &[f64; {p}], tau: &mut V) {{
    arm::inverse_dynamics(q, dq, ddq, x, tau)
}}
#[unsafe(no_mangle)]
pub extern "C" fn WAY_inertia_matrix(q: &V, x: &[f64; {p}], a: &mut [f64; arm::INERTIA_MATRIX_PLACES.len()]) {{
    arm::inertia_matrix_non_zeros(q, x, a)
}}
#[unsafe(no_mangle)]
pub extern "C" fn WAY_derivatives(q: &V, dq: &V, ddq: &V, x: &[f64; {p}], y: &mut [[V; {n}]; 2]) {{
    let [by_q, by_dq] = y;
    arm::inverse_dynamics_derivatives(q, dq, ddq, x, by_q, by_dq)
}}
"""
flags = ["-Copt-level=3", "-Copt-level=3 -Cno-vectorize-slp", "-Copt-level=2 -Cno-vectorize-slp"]
for way, how in zip(rust, flags):
    (here / f"{way}.rs").write_text(library.replace("WAY_", f"{way}_"))
    native = ["-Ctarget-cpu=native", "-Ccodegen-units=1", "--edition=2024"]
    run("rustc", "--crate-type=staticlib", *how.split(), *native, "-o", f"lib{way}.a", f"{way}.rs")

# How each way computes each function.
arguments = {
    "base_regressor": "q[s], v[s], a[s], y",
    "inverse_dynamics": "q[s], v[s], a[s], x, y",
    "inertia_matrix": "q[s], x, y",
    "derivatives": f"q[s], v[s], a[s], x, y{{}}",
}
ways = ours_too + generated_c + peers + rust
calls, declared = [], []
for name in functions:
    for way in ways:
        if way in ours_too:
            declared.append(f"int {way}_{name}(const double **, double **, long long *, double *, int);")
            second = "x" if name == "inertia_matrix" else "v[s]"
            call = f"const double *in[] = {{q[s], {second}, a[s], x}}; double *out[] = {{y}}; {way}_{name}(in, out, 0, memory, 0);"
        elif way in peers:
            declared.append(f"static void (*{way}_{name})(int);")
            call = f"{way}_{name}(s);"
        else:
            declared.append(f"void {way}_{name}();")
            # C has a matrix for each of the two slopes.
            two = f", y + {n * n}" if way in generated_c and name == "derivatives" else ""
            call = f"{way}_{name}({arguments[name].format(two)});"
        calls.append(f"static void {way}_{name}_at(int s) {{ {call} }}")
listed = ",".join("{" + ",".join(f"{way}_{name}_at" for way in ways) + "}" for name in functions)
opened = "".join(
    f"""{{
        void *library = dlopen("{here}/{peer}.so", RTLD_NOW);
        if (!library) return fputs(dlerror(), stderr), 1;
        void (*state)(int, double *, double *, double *) = dlsym(library, "state");
        for (int s = 0; s < 64; s++) state(s, q[s], v[s], a[s]);
        {"".join(f'{peer}_{name} = dlsym(library, "{name}");' for name in functions)}
    }}"""
    for peer in peers
)
(here / "main.c").write_text(f"""
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#define WAYS {len(ways)}
static double q[64][{n}], v[64][{n}], a[64][{n}], x[{max(p, len(base))}], y[{n} * {max(p, 2 * n)}], memory[1000000];
{"".join(declared)}
{"".join(calls)}
static double now(void) {{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec * 1e9 + t.tv_nsec;
}}
int main(void) {{
    static void (*const all[4][WAYS])(int) = {{{listed}}};
    for (int i = 0; i < 64 * {n}; i++) {{
        q[0][i] = 6. * rand() / RAND_MAX - 3, v[0][i] = 4. * rand() / RAND_MAX - 2, a[0][i] = 10. * rand() / RAND_MAX - 5;
    }}
    for (int i = 0; i < {max(p, len(base))}; i++) x[i] = 1. * rand() / RAND_MAX;
    {opened}
    static double best[4][WAYS];
    int calls = 64 * {100 if n < 12 else 10};
    for (int turn = 0; turn < 60; turn++)
        for (int f = 0; f < 4; f++)
            for (int way = 0; way < WAYS; way++) {{
                double begin = now();
                for (int c = 0; c < calls; c++) all[f][way](c & 63);
                double each = (now() - begin) / calls;
                if (!turn || each < best[f][way]) best[f][way] = each;
            }}
    for (int f = 0; f < 4; f++)
        for (int way = 0; way < WAYS; way++) printf("%.1f\\n", best[f][way]);
}}
""")
objects = [f"{way}.o" for way in ours_too + generated_c]
# Each library of Rust brings the same standard library along.
libraries = [*(f"lib{way}.a" for way in rust), "-Wl,-z,muldefs", "-lm", "-lpthread", "-ldl"]
run("gcc", "-O2", "-w", "main.c", *objects, *libraries, "-o", "main")
timed = [float(x) for x in subprocess.run([here / "main"], capture_output=True, text=True, check=True).stdout.split()]
print(f"{urdf.stem}: {n} joints, {len(base)} base parameters (rist: {p}); casadi against pinocchio: {difference:.0e}")
print(f"compilers: gcc{', ' + newest if newest else ''}; ns, and in brackets how many times rist's Rust takes it")
columns = ["casadi", "with our sine", "rist, C", *(f"Pinocchio, {name}" for name in by)]
print(f"{'function':<18} {'operations':>10} {'rist, Rust':>10}" + "".join(f" {column:>20}" for column in columns))
for k, (name, function) in enumerate(functions.items()):
    of = dict(zip(ways, timed[k * len(ways) : (k + 1) * len(ways)]))
    groups = [with_library, with_ours, generated_c, *([peer] for peer in peers)]
    fastest = [min(of[way] for way in group) for group in groups]
    of_rust = min(of[way] for way in rust)
    beside = "".join(f" {ns:>13.0f} ({ns / of_rust:.2f})" for ns in fastest)
    print(f"{name:<18} {function.n_instructions():>10} {of_rust:>10.0f}{beside}")
    if "--ways" in sys.argv:
        print("    Rust: " + ", ".join(f"{how} {of[way]:.0f}" for way, how in zip(rust, flags)))
