"""The model: functions of many states against each other, against the program, and their refusals."""

import concurrent.futures
import pickle
import threading
import time

import numpy as np
import pytest

import rist
from conftest import MODELS, motion


def states(model, count, seed=3):
    return np.random.default_rng(seed).normal(size=(3, count, len(model.coordinates)))


@pytest.mark.parametrize("name", ["panda.yaml", "ur5.urdf", "tree.yaml", "scara.yaml"])
def test_the_quantities_of_a_state_agree(name):
    model = rist.Model.read(MODELS / name)
    q, dq, ddq = states(model, 100)
    names = model.standard_parameters
    standard = np.random.default_rng(1).normal(size=len(names))
    matrix = model.base_parameters.matrix
    base = matrix @ standard
    assert matrix.shape == (len(model.base_parameters), len(names))
    torque = model.torque(q, dq, ddq, base)
    n = len(model.coordinates)
    assert torque.shape == (100, n)
    # Sums of some hundred terms of order one.
    close = dict(rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(model.base_regressor(q, dq, ddq) @ base, torque, **close)
    np.testing.assert_allclose(model.regressor(q, dq, ddq) @ standard, torque, **close)
    np.testing.assert_allclose(model.torque(q, dq, ddq, standard), torque, **close)
    inertia = model.inertia_matrix(q, base)
    assert inertia.shape == (100, n, n)
    np.testing.assert_allclose(np.einsum("aij,aj->ai", inertia, ddq) + model.bias(q, dq, base), torque, **close)
    np.testing.assert_allclose(model.bias(q, parameters=base), model.gravity(q, base), **close)


def differences(f, x, k, h=1e-4):
    """d f / d x[:, k], fourth order."""
    def at(step):
        moved = x.copy()
        moved[:, k] += step
        return f(moved)

    return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)


@pytest.mark.parametrize("name", ["panda.yaml", "ur5.yaml", "stanford.yaml", "tree.yaml"])
def test_the_functions_for_control_agree(name):
    model = rist.Model.read(MODELS / name)
    n, count = len(model.coordinates), 90
    q, dq, ddq = states(model, count)
    x = model.nominal_parameters
    if x is None:
        pytest.skip("no inertial parameters")
    tau = model.torque(q, dq, ddq)
    np.testing.assert_allclose(model.forward_dynamics(q, dq, tau), ddq, rtol=1e-7, atol=1e-7)
    by_q, by_dq = model.torque_derivatives(q, dq, ddq)
    assert by_q.shape == by_dq.shape == (count, n, n)
    # h^4 of truncation, 1e-12 of rounding, times what gravity and an arm make of them.
    scale = np.abs(by_q).max()
    for k in range(n):
        expected = differences(lambda q: model.torque(q, dq, ddq), q, k)
        np.testing.assert_allclose(by_q[:, :, k], expected, atol=1e-8 * scale)
    of_q, of_dq, of_tau = model.forward_dynamics_derivatives(q, dq, tau)
    np.testing.assert_allclose(of_tau @ model.inertia_matrix(q), np.broadcast_to(np.eye(n), (count, n, n)), atol=1e-8)
    scale = np.abs(of_dq).max()
    for k in range(n):
        expected = differences(lambda dq: model.forward_dynamics(q, dq, tau), dq, k)
        np.testing.assert_allclose(of_dq[:, :, k], expected, atol=1e-7 * scale)
    assert of_q.shape == (count, n, n)

    energy = model.energy(q, dq)
    kinetic = 0.5 * np.einsum("ai,aij,aj->a", dq, model.inertia_matrix(q), dq)
    np.testing.assert_allclose(energy[:, 0], kinetic, rtol=1e-9)
    for k in range(n):
        potential = differences(lambda q: model.energy(q, dq)[:, 1], q, k)
        np.testing.assert_allclose(model.gravity(q)[:, k], potential, atol=1e-7 * np.abs(x).max())

    c = model.evaluate("coriolis-matrix", q, dq)
    np.testing.assert_allclose(np.einsum("aij,aj->ai", c, dq) + model.gravity(q), model.bias(q, dq), atol=1e-8)


def test_poses_and_jacobians(ur5):
    q = states(ur5, 70)[0]
    pose, j = ur5.pose("tool0", q), ur5.jacobian("tool0", q, "base")
    assert pose.shape == (70, 3, 4) and j.shape == (70, 6, 6)
    for k in range(6):
        speed = differences(lambda q: ur5.pose("tool0", q), q, k)
        np.testing.assert_allclose(j[:, :3, k], speed[:, :, 3], atol=1e-9)
        turn = np.einsum("aij,akj->aik", speed[:, :, :3], pose[:, :, :3])
        np.testing.assert_allclose(j[:, 3:, k], np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], 1), atol=1e-9)
    np.testing.assert_allclose(np.einsum("aij,aik->ajk", pose[:, :, :3], j[:, :3]), ur5.jacobian("tool0", q)[:, :3], atol=1e-12)
    assert ur5.pose("tool0", q[3]).shape == (3, 4) and ur5.jacobian("tool0", q[3]).shape == (6, 6)
    # Where the joints must be for a pose.
    back = ur5.evaluate("inverse-geometry=tool0", t=pose.reshape(70, 12))
    angles = np.arctan2(back["sin_q"], back["cos_q"])
    assert angles.shape == (70, 8, 6)
    off = np.abs(np.sin((angles - q[:, None, :]) / 2)).max(axis=2)
    assert np.nanmin(off, axis=1).max() < 1e-6


def test_what_a_function_takes_is_said(panda):
    def message(*arguments, **options):
        with pytest.raises(rist.Error) as raised:
            panda.evaluate(*arguments, **options)
        return str(raised.value)

    q = np.zeros((4, 7))
    assert "there is no function `speed`" in message("speed", q)
    assert "tau is missing: the function takes tau=" in message("forward-dynamics", q)
    assert "wrench= is not what the function takes: it takes nothing else" in message("gravity", q, wrench=q)
    assert "the shape (4, 7) is expected" in message("forward-dynamics", q, tau=q[:3])
    assert "q is missing" in message("gravity")
    base = np.ones(43)
    assert "70 standard parameters are expected" in message("joint-reactions", q, parameters=base)
    assert panda.evaluate("joint-reactions", q).shape == (4, 6, 7)
    source = panda.generate(functions=["gravity"], symbols=["all"])
    assert "pub const SYMBOLS" in source


def test_one_state_has_no_dimension_of_states(panda):
    q, dq, ddq = states(panda, 5)
    many = panda.base_regressor(q, dq, ddq)
    one = panda.base_regressor(q[2], dq[2], ddq[2])
    assert one.shape == many.shape[1:] == (7, 43)
    np.testing.assert_array_equal(one, many[2])
    # An empty log is no error.
    assert panda.base_regressor(q[:0]).shape == (0, 7, 43)


def test_layout_and_type_do_not_matter(panda):
    q, dq, ddq = states(panda, 50)
    expected = panda.base_regressor(q, dq, ddq)
    np.testing.assert_array_equal(panda.base_regressor(np.asfortranarray(q), dq, ddq), expected)
    np.testing.assert_array_equal(panda.base_regressor(q.tolist(), dq, ddq), expected)
    np.testing.assert_array_equal(panda.base_regressor(np.repeat(q, 2, axis=0)[::2], dq, ddq), expected)


def test_the_regressors_are_those_of_the_program(panda, program, tmp_path):
    q, dq, ddq = states(panda, 20)
    names = [f"{x}_{c}" for x in ("q", "dq", "ddq") for c in panda.coordinates]
    rows = [",".join(repr(float(x)) for x in row) for row in np.hstack([q, dq, ddq])]
    (tmp_path / "states.csv").write_text("\n".join([",".join(names), *rows]) + "\n")
    path = MODELS / "panda.yaml"
    for quantity, found in [("regressor", panda.regressor(q, dq, ddq)), ("base-regressor", panda.base_regressor(q, dq, ddq))]:
        done = program("evaluate", path, tmp_path / "states.csv", "--quantity", quantity)
        expected = np.loadtxt(done.stdout.splitlines()[1:], delimiter=",").reshape(found.shape)
        # The tape and the compiled function agree to the bit; printed are all digits.
        np.testing.assert_array_equal(found, expected)


def test_base_parameters_have_rules():
    base = rist.Model.read(MODELS / "planar2r_vertical.yaml").base_parameters
    assert base.rules[0] == "ZZR1 = ZZ1 + IA1 + L1^2*M2"
    assert base.names[0] == "ZZR1" and base.units[0] == "kg m^2"
    assert len(base) == 7 and "XX1" in base.no_effect


def test_generated_source_is_that_of_the_program(program, tmp_path):
    path = "models/ur5.yaml"
    model = rist.Model.parse((MODELS / "ur5.yaml").read_text(), path)
    assert model.generate() == program("generate", path).stdout
    functions = ["inertia-matrix", "gravity"]
    program("generate", path, "--language", "c", "--functions", ",".join(functions), "--out", tmp_path / "ur5.c")
    source, header = model.generate("c", functions)
    assert source == (tmp_path / "ur5.c").read_text() and header == (tmp_path / "ur5.h").read_text()


def test_models_are_pickled_with_their_options(ur5):
    model = rist.Model.read(MODELS / "ur5.urdf", rotor_inertia="all", floating_base=True)
    again = pickle.loads(pickle.dumps(model))
    assert again.base_parameters.names == model.base_parameters.names != ur5.base_parameters.names
    assert again.coordinates[0] == "base_x"


def test_errors_say_what_is_expected(panda, program):
    def message(call, *arguments, **options):
        with pytest.raises(rist.Error) as raised:
            call(*arguments, **options)
        return str(raised.value)

    assert issubclass(rist.Error, ValueError)
    missing = message(rist.Model.read, "no/such.urdf")
    assert program("inspect", "no/such.urdf").stderr == f"rist: {missing}\n"
    assert "(N, 7) is expected" in message(panda.regressor, np.zeros((4, 6)))
    assert "that of q, (4, 7), is expected" in message(panda.regressor, np.zeros((4, 7)), np.zeros((3, 7)))
    assert "an array of numbers" in message(panda.regressor, "abc")
    assert "43 base parameters or 70 standard ones" in message(panda.torque, np.zeros(7), parameters=[1.0])
    bare = rist.Model.read(MODELS.parent / "tests/data/robots/planar2r_vertical.yaml")
    assert "it has no inertial parameters" in message(bare.torque, np.zeros(2))
    assert "(did you mean angles=?); there are value, arg, package, root, mimic, angles" in message(rist.Model.read, "a.urdf", angle="meant")
    assert "expected is one of meant, as-given" in message(rist.Model.read, "a.urdf", angles="exact")
    assert "one of rust, c" in message(panda.generate, "fortran")
    assert "anyway=True is for an estimate=" in message(panda.generate, anyway=True)


def test_snapped_angles_are_a_warning():
    text = (MODELS / "ur5.urdf").read_text().replace("1.57079632679", "1.5707")
    assert "1.5707" in text
    with pytest.warns(UserWarning, match="angles are taken for what was meant"):
        rist.Model.parse(text, "ur5.urdf")


def test_the_lock_is_released(panda):
    """Two threads fill arrays while a third, of Python alone, goes on."""
    q, dq, ddq = states(panda, 40_000)
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    ticker = threading.Thread(target=tick)
    ticker.start()
    start = time.perf_counter()
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        a, b = pool.map(lambda seed: panda.base_regressor(q, dq, ddq), [1, 2])
    end = time.perf_counter()
    done.set()
    ticker.join()
    np.testing.assert_array_equal(a, b)
    # Were the lock held, not one tick would come between; how many is the machine's affair.
    assert sum(start < x < end for x in ticks) >= 3


def test_reprs_say_something(panda, ur5):
    assert "43 base parameters, compiled" in repr(panda) and "ZZR1 = ZZ1 + YY2" in repr(panda)
    assert panda._repr_html_().startswith("<iframe") and panda.base_parameters._repr_html_().startswith("<table>")
    for thing in (rist.Model, rist.identify, rist.plan, rist.Model.base_regressor):
        assert thing.__doc__ and len(thing.__doc__) > 60
    assert "cutoff=None" in rist.identify.__text_signature__
