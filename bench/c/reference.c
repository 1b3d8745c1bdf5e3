/* Reference solution: Gragg-Bulirsch-Stoer extrapolation in 80-bit long double, every switch of the contact located on real steps.

   Shares nothing with rsc's kernel but the scene's matrices: physical coordinates, divided by the masses here, phase from t by the library's sine and cosine, the modified
   midpoint rule extrapolated `columns` times (order 2 columns), no interpolation: each output time is the end of a step. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef long double R;
enum { OPEN, CLOSING, OPENING, CLIPPED };
enum { MAX_STATES = 256, MAX_COLUMNS = 12, MAX_ENTRIES = 4096 };

typedef struct { int row, column; R stiffness, damping, gyroscopic; } Entry;

typedef struct {
    int n, k; /* rotor and stator coordinates */
    int n_entries_r, n_entries_s;
    Entry entries_r[MAX_ENTRIES], entries_s[MAX_ENTRIES];
    R unbalance[MAX_STATES], euler[MAX_STATES];
    int i_r, i_s;
    R per_mass_r, per_mass_s, gap, friction, k_c, b_c, omega, omega_dot;
} Problem;

static int sparse(Entry *entries, int n, const double *mass, const double *stiffness, const double *damping, const double *gyroscopic)
{
    int count = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            R g = gyroscopic ? gyroscopic[i * n + j] : 0.0L;
            if (stiffness[i * n + j] == 0.0 && damping[i * n + j] == 0.0 && g == 0.0L) continue;
            if (count == MAX_ENTRIES) return -1;
            R m = mass[i];
            entries[count++] = (Entry){i, j, stiffness[i * n + j] / m, damping[i * n + j] / m, g / m};
        }
    return count;
}

typedef struct { R d_y, d_z, distance, delta, delta_dot, force; } Contact;

static Contact contact(const Problem *p, const R *y)
{
    int n = p->n, k = p->k, half = 2 * (n + k), r = p->i_r, q = 2 * n + p->i_s;
    Contact c;
    c.d_y = y[r] - (k ? y[q] : 0.0L);
    c.d_z = y[n + r] - (k ? y[q + k] : 0.0L);
    R v_y = y[half + r] - (k ? y[half + q] : 0.0L), v_z = y[half + n + r] - (k ? y[half + q + k] : 0.0L);
    c.distance = sqrtl(c.d_y * c.d_y + c.d_z * c.d_z);
    c.delta = p->gap - c.distance;
    c.delta_dot = c.distance > 0.0L ? -(c.d_y * v_y + c.d_z * v_z) / c.distance : 0.0L;
    c.force = -p->k_c * c.delta - p->b_c * c.delta_dot;
    return c;
}

static int mode_of(const Problem *p, const R *y)
{
    Contact c = contact(p, y);
    if (c.delta >= 0.0L) return OPEN;
    if (c.delta_dot <= 0.0L) return CLOSING;
    return c.force >= 0.0L ? OPENING : CLIPPED;
}

/* distance to the nearest switch out of a mode, scaled to a length: only guides the search, mode_of decides */
static R margin(const Problem *p, int mode, const R *y)
{
    Contact c = contact(p, y);
    R rate = c.delta_dot / sqrtl(p->k_c * p->per_mass_r), force = c.force / p->k_c;
    if (mode == OPEN) return c.delta;
    if (mode == CLOSING) return fminl(-c.delta, -rate);
    if (mode == OPENING) return fminl(rate, force);
    return fminl(-c.delta, fminl(rate, -force));
}

/* the field of one mode, continued analytically beyond its borders */
static void field(const Problem *p, int mode, R t, const R *y, R *out)
{
    int n = p->n, k = p->k, half = 2 * (n + k);
    const R *v = y + half;
    R phi = (p->omega + 0.5L * p->omega_dot * t) * t, omega = p->omega + p->omega_dot * t;
    R c = cosl(phi), s = sinl(phi);
    for (int i = 0; i < half; i++) out[i] = v[i];
    for (int i = 0; i < n; i++) {
        out[half + i] = p->unbalance[i] * omega * omega * c + p->euler[i] * p->omega_dot * s;
        out[half + n + i] = p->unbalance[i] * omega * omega * s - p->euler[i] * p->omega_dot * c;
    }
    for (int i = half + 2 * n; i < 2 * half; i++) out[i] = 0.0L;
    for (int e = 0; e < p->n_entries_r; e++) {
        const Entry *m = &p->entries_r[e];
        out[half + m->row] -= m->stiffness * y[m->column] + m->damping * v[m->column] + omega * m->gyroscopic * v[n + m->column];
        out[half + n + m->row] -= m->stiffness * y[n + m->column] + m->damping * v[n + m->column] - omega * m->gyroscopic * v[m->column];
    }
    for (int e = 0; e < p->n_entries_s; e++) {
        const Entry *m = &p->entries_s[e];
        int row = 2 * n + m->row, column = 2 * n + m->column;
        out[half + row] -= m->stiffness * y[column] + m->damping * v[column];
        out[half + row + k] -= m->stiffness * y[column + k] + m->damping * v[column + k];
    }
    if (mode == OPEN || mode == CLIPPED) return;
    Contact g = contact(p, y);
    R force = (-p->k_c * g.delta - (mode == OPENING ? p->b_c * g.delta_dot : 0.0L)) / g.distance;
    R f_y = force * (g.d_y - p->friction * g.d_z), f_z = force * (g.d_z + p->friction * g.d_y);
    out[half + p->i_r] -= f_y * p->per_mass_r;
    out[half + n + p->i_r] -= f_z * p->per_mass_r;
    if (k) {
        out[half + 2 * n + p->i_s] += f_y * p->per_mass_s;
        out[half + 2 * n + k + p->i_s] += f_z * p->per_mass_s;
    }
}

static void step(const Problem *p, int mode, R t, const R *y, const R *slope, R h, int columns, R *out)
{
    static R table[MAX_COLUMNS][MAX_STATES];
    R before[MAX_STATES], now[MAX_STATES], f[MAX_STATES];
    int size = 4 * (p->n + p->k);
    for (int j = 0; j < columns; j++) {
        int parts = 2 * (j + 1);
        R small = h / parts;
        for (int i = 0; i < size; i++) before[i] = y[i], now[i] = y[i] + small * slope[i];
        for (int part = 1; part < parts; part++) {
            field(p, mode, t + part * small, now, f);
            for (int i = 0; i < size; i++) {
                R next = before[i] + 2.0L * small * f[i];
                before[i] = now[i];
                now[i] = next;
            }
        }
        /* Aitken-Neville in small^2; the even number of parts makes Gragg's smoothing unnecessary */
        for (int i = 0; i < size; i++) {
            R value = now[i];
            for (int m = 1; m <= j; m++) {
                R ratio = (R)(j + 1) / (j + 1 - m), held = table[m - 1][i];
                table[m - 1][i] = value;
                value += (value - held) / (ratio * ratio - 1.0L);
            }
            table[j][i] = value;
        }
    }
    memcpy(out, table[columns - 1], size * sizeof(R));
}

/* rate of the margin along the field of a mode */
static R approach(const Problem *p, int mode, R t, const R *y, R h)
{
    R slope[MAX_STATES], ahead[MAX_STATES];
    int size = 4 * (p->n + p->k);
    field(p, mode, t, y, slope);
    for (int i = 0; i < size; i++) ahead[i] = y[i] + 1e-7L * h * slope[i];
    return (margin(p, mode, ahead) - margin(p, mode, y)) / (1e-7L * h);
}

/* a point inside a step that starts and ends in its mode where the mode is left for a moment, or 0 */
static R excursion(const Problem *p, int mode, R t, const R *y, const R *slope, R h, int columns, R *y_new)
{
    R a = 0.0L, b = h, f_a = approach(p, mode, t, y, h), f_b = approach(p, mode, t + h, y_new, h), inside[MAX_STATES];
    R g_a = margin(p, mode, y), g_b = margin(p, mode, y_new);
    if (!(f_a < 0.0L && f_b > 0.0L && g_a + f_a * h < 0.0L && g_b - f_b * h < 0.0L)) return 0.0L;
    for (int i = 0; i < 40 && b - a > 1e-6L * h; i++) {
        R middle = i % 3 == 2 ? 0.5L * (a + b) : a + (b - a) * fminl(fmaxl(f_a / (f_a - f_b), 0.01L), 0.99L);
        step(p, mode, t, y, slope, middle, columns, inside);
        if (mode_of(p, inside) != mode) {
            memcpy(y_new, inside, sizeof inside);
            return middle;
        }
        R f = approach(p, mode, t + middle, inside, h);
        if (f < 0.0L) a = middle, f_a = f;
        else b = middle, f_b = f;
    }
    return 0.0L;
}

/* Fills out (rows, states) with the states on the grid; returns the number of switches, -1 when the problem is too large. */
long reference(int n, int k, const double *m_r, const double *k_r, const double *b_r, const double *g_r, const double *m_s,
               const double *k_s, const double *b_s, const double *unbalance, const double *euler, const int *index, const double *numbers, const double *start,
               double rate, int substeps, int columns, long rows, double *out)
{
    static Problem p;
    static R y[MAX_STATES], y_new[MAX_STATES], slope[MAX_STATES];
    int size = 4 * (n + k);
    if (size > MAX_STATES || columns > MAX_COLUMNS) return -1;
    p.n = n, p.k = k, p.i_r = index[0], p.i_s = index[1];
    p.n_entries_r = sparse(p.entries_r, n, m_r, k_r, b_r, g_r);
    p.n_entries_s = sparse(p.entries_s, k, m_s, k_s, b_s, 0);
    if (p.n_entries_r < 0 || p.n_entries_s < 0) return -1;
    for (int i = 0; i < n; i++) p.unbalance[i] = unbalance[i] / (R)m_r[i], p.euler[i] = euler[i] / (R)m_r[i];
    p.per_mass_r = 1.0L / m_r[p.i_r], p.per_mass_s = k ? 1.0L / m_s[p.i_s] : 0.0L;
    p.gap = numbers[0], p.friction = numbers[1], p.k_c = numbers[2], p.b_c = numbers[3];
    p.omega = numbers[4], p.omega_dot = ((R)numbers[5] - (R)numbers[4]) / (R)numbers[6];
    for (int i = 0; i < size; i++) y[i] = start[i], out[i] = start[i];
    int mode = mode_of(&p, y);
    long switches = 0;
    for (long row = 1; row < rows; row++) {
        for (int sub = 0; sub < substeps; sub++) {
            R t = ((R)(row - 1) + (R)sub / substeps) / rate, left = 1.0L / ((R)rate * substeps);
            while (left > 0.0L) {
                R h = left;
                field(&p, mode, t, y, slope);
                step(&p, mode, t, y, slope, left, columns, y_new);
                R beyond = mode_of(&p, y_new) != mode ? left : excursion(&p, mode, t, y, slope, left, columns, y_new);
                if (beyond > 0.0L) {
                    R near = 0.0L, far = beyond, g_near = fmaxl(margin(&p, mode, y), 0.0L), g_far = fminl(margin(&p, mode, y_new), 0.0L);
                    for (int i = 0, side = 0; i < 100 && far - near > 1e-19L * t + 1e-24L; i++) {
                        R part = g_near > g_far ? g_near / (g_near - g_far) : 0.5L;
                        /* every fourth guess is the middle: both ends close in whatever the margin looks like */
                        R guess = i % 4 == 3 ? 0.5L * (near + far) : near + (far - near) * fminl(fmaxl(part, 1e-6L), 1.0L - 1e-6L);
                        if (!(guess > near && guess < far)) break;
                        step(&p, mode, t, y, slope, guess, columns, y_new);
                        R g = margin(&p, mode, y_new);
                        if (mode_of(&p, y_new) != mode) {
                            far = guess, g_far = fminl(g, 0.0L);
                            if (side == 1) g_near *= 0.5L;
                            side = 1;
                        } else {
                            near = guess, g_near = fmaxl(g, 0.0L);
                            if (side == -1) g_far *= 0.5L;
                            side = -1;
                        }
                    }
                    h = far;
                    step(&p, mode, t, y, slope, h, columns, y_new);
                    mode = mode_of(&p, y_new);
                    switches++;
                }
                memcpy(y, y_new, size * sizeof(R));
                t += h;
                left -= h;
            }
        }
        for (int i = 0; i < size; i++) out[row * size + i] = y[i];
    }
    return switches;
}
