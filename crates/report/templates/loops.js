// Closes the loops of a robot that Drawing draws: the passive variables follow the coordinates.
//   Loops.follow(robot, from closed values, to coordinates)      the closed values, or null where the way ends
//   Loops.close(robot, values)                                   moves the passive ones; false where they do not close
const Loops = (() => {
  const { axis, compose, cross, on, placed, plus, poses } = Drawing.kinematics;

  // Of each loop: from one frame to the other, and the sine of the turn between them.
  const gap = (robot, x) => {
    const all = poses(robot, x);
    return robot.loops.flatMap(pair => {
      const [a, b] = pair.map(frame => compose(on(all, frame), placed(frame, x)));
      const turn = [0, 1, 2].map(k => cross(axis(a, k), axis(b, k))).reduce((sum, v) => plus(sum, v, 0.5), [0, 0, 0]);
      return [...plus(axis(b, 3), axis(a, 3), -1), ...turn];
    });
  };
  const largest = e => e.reduce((most, v) => Math.max(most, Math.abs(v)), 0);
  // y of (J'J + mu 1) y = J'e, by elimination: the matrix is positive definite.
  const leastSquares = (columns, e) => {
    const n = columns.length;
    const inner = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
    const m = columns.map((a, i) => [...columns.map((b, j) => inner(a, b) + (i === j ? 1e-12 : 0)), inner(a, e)]);
    for (let k = 0; k < n; k++) {
      for (let i = k + 1; i < n; i++) {
        const factor = m[i][k] / m[k][k];
        for (let j = k; j <= n; j++) m[i][j] -= factor * m[k][j];
      }
    }
    const y = new Array(n).fill(0);
    for (let k = n - 1; k >= 0; k--) y[k] = (m[k][n] - y.reduce((sum, v, j) => sum + (j > k ? m[k][j] * v : 0), 0)) / m[k][k];
    return y;
  };
  // Moves the passive variables of x until the loops are closed, by Gauss-Newton; false where they do not close.
  const close = (robot, x) => {
    const passive = robot.variables.map((_, k) => k).slice(robot.coordinates);
    if (!passive.length) return true;
    for (let step = 0; step < 40; step++) {
      const e = gap(robot, x);
      if (largest(e) < 1e-10) return true;
      const columns = passive.map(k => {
        const [ahead, behind] = [1e-6, -1e-6].map(h => gap(robot, x.map((v, i) => i === k ? v + h : v)));
        return ahead.map((v, i) => (v - behind[i]) / 2e-6);
      });
      const y = leastSquares(columns, e);
      for (let fraction = 1; fraction > 1e-3; fraction /= 2) {
        const next = x.slice();
        passive.forEach((k, i) => { next[k] -= fraction * y[i]; });
        if (fraction < 2e-3 || largest(gap(robot, next)) < largest(e)) { next.forEach((v, k) => { x[k] = v; }); break; }
      }
    }
    return largest(gap(robot, x)) < 1e-7;
  };
  // From closed values to the coordinates of others, in strides that keep the assembly; null where the way ends.
  const follow = (robot, from, to) => {
    const n = robot.coordinates;
    if (robot.variables.length === n) return to.slice(0, n);
    const most = largest(from.slice(0, n).map((v, k) => to[k] - v));
    const strides = Math.min(200, Math.max(1, Math.ceil(most / 0.05)));
    const x = from.slice();
    for (let s = 1; s <= strides; s++) {
      for (let k = 0; k < n; k++) x[k] = from[k] + (to[k] - from[k]) * s / strides;
      if (!close(robot, x)) return null;
    }
    return x;
  };
  return { close, follow };
})();
