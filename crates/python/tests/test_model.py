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
    assert "is angles= meant? there are value, mimic, angles" in message(rist.Model.read, "a.urdf", angle="meant")
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
    assert panda._repr_html_().startswith("<table>") and "&" not in panda.name
    for thing in (rist.Model, rist.identify, rist.plan, rist.Model.base_regressor):
        assert thing.__doc__ and len(thing.__doc__) > 60
    assert "cutoff=None" in rist.identify.__text_signature__
