
/* ---- External torque, contact and load, one call a cycle ---- */

#define N LENGTH
#define TEN 10
#define D DIRECTIONS
#define DETERMINED ((real)0.1)
#define SATURATED_WITHIN ((real)1e-3)
#define LARGEST_NEGATIVE_MASS ((real)3)
#define SQUARE(x) ((x) * (x))
#define ABS(x) ((x) < 0 ? -(x) : (x))

CONSTANTS
/* Whether it is a number, and not infinite. */
static int is_number(real x)
{
    return x - x == 0;
}

void PREFIX_start(PREFIX_monitor *m)
{
    const PREFIX_monitor none = {0};
    int j, k;
    *m = none;
    m->load.last_joint = -1;
    for (j = 0; j < N; j++)
        m->change_square[j] = SQUARE(change_deviation[j]);
    for (k = 0; k < TEN; k++) {
        m->load.current.triangle[k][k] = 1 / load_start[k];
        m->load.former.triangle[k][k] = 1 / load_start[k];
    }
}

/* r' = (r + K (p' - p - known T)) / (1 + K T), with the mean of known at both ends of the period. half_period: T / 2; share: 1 / (1
   + K T), or 0 at the first cycle. */
static void observe_one(real p, real known, real half_period, real share, real *p_before, real *known_before, real *r)
{
    const real unexplained = p - *p_before - (known + *known_before) * half_period;
    *r = (*r + GAIN * unexplained) * share;
    *p_before = p;
    *known_before = known;
}

/* Rotates the row h x = z, of unit variance, into the triangle. The row is lost. */
static void push_row(PREFIX_payload *l, real h[TEN], real value)
{
    int k, c;
    for (k = 0; k < TEN; k++) {
        const real a = l->triangle[k][k], b = h[k], length = SQRT(a * a + b * b);
        const real cosine = a / length, sine = b / length, z = l->right[k];
        for (c = k; c < TEN; c++) {
            const real t = l->triangle[k][c], x = h[c];
            l->triangle[k][c] = cosine * t + sine * x;
            h[c] = cosine * x - sine * t;
        }
        l->right[k] = cosine * z + sine * value;
        value = cosine * value - sine * z;
    }
}

/* x of R x = right. */
static void solve(const PREFIX_payload *l, const real right[TEN], real x[TEN])
{
    int k, c;
    for (k = TEN - 1; k >= 0; k--) {
        x[k] = right[k];
        for (c = k + 1; c < TEN; c++)
            x[k] -= l->triangle[k][c] * x[c];
        x[k] /= l->triangle[k][k];
    }
}

/* Parameters and standard deviations of the load that is estimated now, and the inverse of its triangle, also a triangle. */
static void estimate_load(const PREFIX_payload *l, real x[TEN], real sigma[TEN], real inverse[TEN][TEN])
{
    real half[TEN][D];
    int k, c, i, d;
    solve(l, l->right, x);
    for (c = 0; c < TEN; c++) {
        inverse[c][c] = 1 / l->triangle[c][c];
        for (k = c - 1; k >= 0; k--) {
            real sum = 0;
            for (i = k + 1; i <= c; i++)
                sum -= l->triangle[k][i] * inverse[i][c];
            inverse[k][c] = sum / l->triangle[k][k];
            inverse[c][k] = 0;
        }
    }
    for (k = 0; k < TEN; k++) {
        for (d = 0; d < D; d++)
            half[k][d] = 0;
        for (c = 0; c <= k; c++)
            for (d = 0; d < D; d++)
                half[k][d] += inverse[c][k] * l->shared[c][d];
    }
    for (k = 0; k < TEN; k++) {
        real variance = 0, gain[D] = {0};
        for (c = k; c < TEN; c++) {
            variance += SQUARE(inverse[k][c]);
            for (d = 0; d < D; d++)
                gain[d] += inverse[k][c] * half[c][d];
        }
        for (d = 0; d < D; d++)
            variance += SQUARE(gain[d]);
        sigma[k] = SQRT(variance);
    }
}

/* Starts the estimate of a new load, and keeps the former one. */
static void start_test(PREFIX_load *l)
{
    const PREFIX_payload none = {0};
    int k;
    l->former = l->current;
    l->current = none;
    for (k = 0; k < TEN; k++)
        l->current.triangle[k][k] = 1 / load_start[k];
    l->phase = 1;
    l->age = 0;
    l->misfit = 0;
    l->misfit_of_one = 0;
}

/* The phase before the rows of a cycle: 0 free, 1 testing a new load, 2 settling on it. */
static void begin_load(PREFIX_load *l, int is_contact, real period)
{
    const int is_late = l->age > DECISION;
    if (is_contact && (l->phase == 0 || (l->phase == 2 && is_late)))
        start_test(l);
    else if (!is_contact && l->phase == 1) {
        l->current = l->former;
        l->phase = 0;
    } else if (!is_contact)
        l->phase = 0;
    l->age += period;
}

/* Whether the load has changed, after the rows of a cycle. */
static int end_load(PREFIX_load *l)
{
    real x[TEN], sigma[TEN], inverse[TEN][TEN];
    int k, c, is_found = l->phase == 1 && l->age > DECISION && l->misfit < LARGEST_MISFIT;
    /* If a torque of one joint alone explains the contact nearly as well, friction of this joint may have changed. */
    is_found = is_found && (N == 1 || l->misfit_of_one > LARGEST_MISFIT * (l->misfit > 1 ? l->misfit : 1));
    estimate_load(&l->current, x, sigma, inverse);
    /* No body has a negative mass. */
    is_found = is_found && sigma[9] < DETERMINED * load_start[9] && x[9] > -LARGEST_NEGATIVE_MASS * sigma[9];
    if (is_found || l->phase == 2 || (l->phase == 0 && l->has_load)) {
        for (k = 0; k < TEN; k++) {
            l->parameters[k] = x[k];
            l->sigma[k] = sigma[k];
            l->is_determined[k] = sigma[k] < DETERMINED * load_start[k];
            for (c = 0; c < TEN; c++)
                l->inverse[k][c] = inverse[k][c];
        }
    }
    if (is_found) {
        l->phase = 2;
        l->age = 0;
        l->has_load = 1;
    }
    return is_found;
}

int PREFIX_monitor_step(PREFIX_monitor *m, const PREFIX_real q[N], const PREFIX_real dq[N], const PREFIX_real tau[N], PREFIX_real period)
{
    real p[N], b[N], ddq[N], lp[N][TEN], lb[N][TEN], y[UPPER_N_NON_ZEROS], shared[N][D], predicted[N] = {0}, direction[N], friction[N] = {0},
        column[FRICTIONS], largest = 0, squares = 0, carried_squares = 0, candidate[TEN], half_period, share;
    int j, k, c, d, is_settling, is_usable = period > 0 && period < LONGEST_PERIOD, used = 0, status = 0;
    for (j = 0; j < N; j++)
        is_usable = is_usable && is_number(q[j]) && is_number(dq[j]) && is_number(tau[j]);
    if (!is_usable) {
        m->has_started = 0;
        return UPPER_NOT_USED;
    }
    half_period = (real)0.5 * period;
    share = m->has_started ? 1 / (1 + GAIN * period) : 0;
    PREFIX_momentum_and_rate(q, dq, PREFIX_x, p, b);
    PREFIX_LOAD_MOMENTUM(q, dq, lp, lb);
    for (j = 0; j < N; j++) {
        m->slow[j] = m->has_started ? m->slow[j] + GAIN * period * share * (dq[j] - m->slow[j]) : dq[j];
        ddq[j] = GAIN * (dq[j] - m->slow[j]);
    }
    PREFIX_base_regressor_non_zeros(q, dq, ddq, y);
    for (j = 0; j < N; j++)
        for (d = 0; d < D; d++)
            shared[j][d] = 0;
    for (k = 0; k < UPPER_N_NON_ZEROS; k++) {
        real *const sums = shared[PREFIX_non_zeros[k][0]];
        const real *const row = factor[PREFIX_non_zeros[k][1]];
        predicted[PREFIX_non_zeros[k][0]] += y[k] * friction_base[PREFIX_non_zeros[k][1]];
        for (d = 0; d < D; d++)
            sums[d] += y[k] * row[d];
    }
    for (j = 0; j < N; j++)
        direction[j] = dq[j] > smooth_speed[j] ? 1 : dq[j] < -smooth_speed[j] ? -1 : dq[j] / smooth_speed[j];
    friction_columns(dq, ddq, tau, predicted, direction, column);
    for (k = 0; k < FRICTIONS; k++) {
        friction[friction_joint[k]] += friction_value[k] * column[k];
        for (d = 0; d < D; d++)
            shared[friction_joint[k]][d] += column[k] * factor[COLUMNS + k][d];
    }
    for (j = 0; j < N; j++) {
        observe_one(p[j], tau[j] + b[j] - friction[j], half_period, share, &m->momentum[j], &m->known[j], &m->external[j]);
        for (c = 0; c < TEN; c++)
            observe_one(lp[j][c], lb[j][c], half_period, share, &m->load_momentum[j][c], &m->load_known[j][c], &m->row[j][c]);
    }
    m->load.last_joint = -1;
    for (j = 0; j < N; j++) {
        const real relative = dq[j] / low_speed_speed[j];
        real explained = 0, variance = 0, none = 0, slow, change, square, scale, beyond;
        /* The slowness passes the filter as an error of friction does. */
        observe_one(0, -1 / (1 + relative * relative), half_period, share, &none, &m->low_known[j], &m->low[j]);
        slow = m->low[j];
        for (c = 0; c < TEN; c++) {
            real product = 0;
            explained -= m->load.parameters[c] * m->row[j][c];
            for (k = 0; k <= c; k++)
                product += m->load.inverse[k][c] * m->row[j][k];
            variance += SQUARE(product);
        }
        m->beyond[j] = m->external[j] - explained;
        change = m->beyond[j] - m->before[j];
        m->before[j] = m->beyond[j];
        square = change * change > 9 * m->change_square[j] ? 9 * m->change_square[j] : change * change;
        m->change_square[j] += period / (SCALE_MEMORY + period) * (square - m->change_square[j]);
        scale = SQRT(m->change_square[j]) / change_deviation[j];
        scale = scale > 1 ? scale : 1;
        m->noise_variance[j] = SQUARE(scale * noise[j]) + SQUARE(low_speed[j] * slow);
        m->dry[j] = dry[j] * slow;
        for (d = 0; d < D; d++)
            variance += SQUARE(shared[j][d]);
        m->limit[j] = THRESHOLD * SQRT(m->noise_variance[j] + variance) + m->dry[j];
        beyond = ABS(m->beyond[j]) - m->dry[j];
        beyond = (beyond > 0 ? beyond : 0) / SQRT(m->noise_variance[j] + variance);
        largest = beyond > largest ? beyond : largest;
        if (beyond > SIGNIFICANT)
            m->load.last_joint = j;
    }
    /* Contact ends when all joints were below half of the threshold for the hold time. */
    if (!m->is_contact && largest > THRESHOLD)
        status |= UPPER_BEGINS;
    m->quiet = largest > (real)0.5 * THRESHOLD ? 0 : m->quiet + period;
    m->is_contact = largest > THRESHOLD || (m->is_contact && m->quiet < HOLD);
    begin_load(&m->load, m->is_contact, period);
    is_settling = m->load.phase == 1 && m->load.age < SETTLING;
    solve(&m->load.current, m->load.current.right, candidate);
    largest = 0;
    /* A row of weight 0 changes nothing, but takes the same time. */
    for (j = 0; j < N; j++) {
        const int is_saturated = ABS(ABS(tau[j]) - effort[j]) < SATURATED_WITHIN * effort[j];
        const int is_used = m->dry[j] < SQRT(m->noise_variance[j]) && !is_settling && !is_saturated;
        /* The factor is for the correlation of the errors from cycle to cycle. */
        const real row_variance = SQUARE(load_factor[j]) * m->noise_variance[j], weight = is_used ? 1 / SQRT(row_variance) : 0;
        const real memory_share = period / (MISFIT_MEMORY + period);
        real scaled[TEN], residual = m->external[j], mean_variance = row_variance * memory_share / (2 - memory_share);
        if (is_saturated)
            status |= UPPER_SATURATED;
        for (c = 0; c < TEN; c++)
            residual += candidate[c] * m->row[j][c];
        for (d = 0; d < D; d++)
            mean_variance += SQUARE(shared[j][d]);
        /* Means of the residuals after the new and the carried load: noise averages out, an error of the robot's parameters does not. */
        if (m->load.phase == 1 && is_used) {
            real square;
            m->mean[j] += memory_share * (residual - m->mean[j]);
            m->carried_mean[j] += memory_share * (m->beyond[j] - m->carried_mean[j]);
            square = SQUARE(m->carried_mean[j]) / mean_variance;
            squares += SQUARE(m->mean[j]) / mean_variance;
            carried_squares += square;
            largest = square > largest ? square : largest;
            used++;
        } else if (is_settling)
            m->mean[j] = m->carried_mean[j] = 0;
        for (c = 0; c < TEN; c++) {
            scaled[c] = -m->row[j][c] * weight;
            for (d = 0; d < D; d++)
                m->load.current.shared[c][d] += scaled[c] * weight * shared[j][d];
        }
        push_row(&m->load.current, scaled, m->external[j] * weight);
    }
    if (m->load.phase == 1) {
        const real memory_share = period / (MISFIT_MEMORY + period);
        m->load.misfit += memory_share * (squares / (used > 1 ? used : 1) - m->load.misfit);
        carried_squares = (carried_squares - largest) / (used > 1 ? used - 1 : 1);
        m->load.misfit_of_one += memory_share * (carried_squares - m->load.misfit_of_one);
    }
    if (end_load(&m->load))
        status |= UPPER_LOAD_CHANGED;
    m->has_started = 1;
    return status | (m->is_contact ? UPPER_CONTACT : 0);
}

int PREFIX_load_candidate(const PREFIX_monitor *m, PREFIX_real x[10], PREFIX_real sigma[10])
{
    real inverse[TEN][TEN];
    const int is_tested = m->load.phase == 1 && m->load.age >= SETTLING;
    if (is_tested)
        estimate_load(&m->load.current, x, sigma, inverse);
    return is_tested;
}

#undef N
#undef TEN
#undef D
#undef FRICTIONS
