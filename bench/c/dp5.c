/* The C yardstick: rsc's Dormand-Prince 5(4) kernel (docs/maintainers/kernel.md) written out in plain C with GCC's vector types, for N complex modal
   coordinates known at compile time (-DN=...). Same method, same switches, control, output and (with -DLEDGER) energies; no checkpoints, no
   chunks, no contact ring, no regularised friction, one straight piece of speed. -DFULL: damping matrix; -DGYRO: gyroscopic matrix. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#define L (2 * N)
#ifdef __AVX512F__
#define W (L <= 16 ? 4 : 8) /* a register of eight closes a port to all other arithmetic */
#else
#define W 4 /* GCC would put vectors of eight together from others, through memory */
#endif
#define NB ((L + W - 1) / W)
#define IN static inline __attribute__((always_inline))
#define EACH for (int j = 0; j < NB; j++)
#if defined(FULL) || defined(GYRO)
#define COUPLED /* else every coordinate has a damping of its own, whose work comes from a step's ends */
#endif
#define LIKELY(x) __builtin_expect(!!(x), 1)

typedef double V __attribute__((vector_size(8 * W)));
typedef int64_t VI __attribute__((vector_size(8 * W)));
typedef struct { V b[NB]; } X;
typedef struct { double y, z; } Pair;

IN X scale(double a, X k) { EACH k.b[j] = a * k.b[j]; return k; }
IN X plus(double a, X k, X base) { EACH base.b[j] += a * k.b[j]; return base; } /* contracted to one FMA */
IN X add(X a, X b) { EACH a.b[j] += b.b[j]; return a; }
IN X mul(X a, X b) { EACH a.b[j] *= b.b[j]; return a; }
IN X fma_(X a, X b, X c) { EACH c.b[j] += a.b[j] * b.b[j]; return c; }
IN X spread(double a) { X r; EACH r.b[j] = a - (V){0}; return r; }
IN X load(const double *p) { X r; double t[NB * W] = {0}; memcpy(t, p, L * sizeof(double)); memcpy(&r, t, sizeof r); return r; }
IN void store(double *p, X x) { memcpy(p, &x, L * sizeof(double)); }
#if W == 4
#define SWAPPED (VI){1, 0, 3, 2}
#define IOTA {0, 1, 2, 3}
#define SIGNS (V){-1, 1, -1, 1}
#else
#define SWAPPED (VI){1, 0, 3, 2, 5, 4, 7, 6}
#define IOTA {0, 1, 2, 3, 4, 5, 6, 7}
#define SIGNS (V){-1, 1, -1, 1, -1, 1, -1, 1}
#endif
IN X swap(X x) { EACH x.b[j] = __builtin_shuffle(x.b[j], SWAPPED); return x; }
IN X times_i(X x) { EACH x.b[j] = SIGNS * __builtin_shuffle(x.b[j], SWAPPED); return x; }
IN X pair_square(X x) { x = mul(x, x); return add(x, swap(x)); }
IN Pair pair_sum(X x)
{
    V s = x.b[0];
    for (int j = 1; j < NB; j++) s += x.b[j];
#if W == 4
    return (Pair){s[0] + s[2], s[1] + s[3]};
#else
    typedef double V4 __attribute__((vector_size(32)));
    V4 low, high;
    memcpy(&low, &s, 32), memcpy(&high, (char *)&s + 32, 32);
    low += high;
    return (Pair){low[0] + low[2], low[1] + low[3]};
#endif
}
IN X fill(double y, double z) { X r; EACH for (int i = 0; i < W; i += 2) r.b[j][i] = y, r.b[j][i + 1] = z; return r; }
/* by the bits: a NaN is above every number */
IN V larger(V a, V b) { VI m = (VI)a > (VI)b; return (V)((m & (VI)a) | (~m & (VI)b)); }
IN double largest(X x)
{
    EACH x.b[j] = (V)((VI)x.b[j] & INT64_MAX);
    V m = x.b[0];
    for (int j = 1; j < NB; j++) m = larger(m, x.b[j]);
#if W == 8
    m = larger(m, __builtin_shuffle(m, (VI){4, 5, 6, 7, 0, 1, 2, 3}));
#endif
    return larger(m, __builtin_shuffle(m, (VI)IOTA ^ 2))[0];
}

typedef struct {
    X stiffness, damping, contact_row, force_row, unbalance, i_unbalance, euler, i_euler, load, scale_x, scale_v;
    double gap, mu, k_c, b_c, switch_tol, per_rtol2, h_max, divergence2, rate;
    X damping_columns[N], gyroscopic_columns[N];
    double end, speed, speed_rate; /* s, Hz, Hz/s */
} Con;

typedef struct { double hi, lo, phase, speed, cos, sin; } Clock;
typedef struct { double re, im, omega, cos, sin; } Turn;
typedef struct { double k, b; } Law;
typedef struct { double d_y, d_z, inverse, distance, p, along, rate, tangential, size; } Kin;
typedef struct { X damping, drive; double contact, friction; } Powers;
typedef struct { X x, v, a; Powers w; Clock clock; Kin kin; } State;
enum { OPEN, CLOSING, OPENING, CLIPPED };
enum { FINISHED = 2, DIVERGED = 3, COLLAPSED = 4 };

/* ---- rotation: at a step's end from its phase in turns, at the stages, four at once, from the rotation at the step's start */
#define TP 6.283185307179586476925
IN V whole(V x) { const double big = 6755399441055744.0; return (x + big) - big; }
/* (cos - 1)/r^2 and sin/r of r turns, q = r^2 */
IN void polynomials(V q, V *c, V *s)
{
    static const double C[11] = {1.0, -19.739208802178717238, 64.939394022668291491, -85.456817206693727736, 60.244641371876660363,
        -26.426256783374397453, 7.9035363713184688042, -1.7143907110886720654, 0.28200596845579121507, -0.036382841142545670772, 0.0037798342006800393792};
    static const double S[11] = {6.2831853071795864769, -41.341702240399760234, 81.605249276075054203, -76.705859753061385842, 42.058693944897653145,
        -15.094642576822990392, 3.8199525848482821277, -0.71812230177850051223, 0.10422916220813984117, -0.012031585942120627233, 0.0011309237482517961878};
    V q2 = q * q;
    V e = (((C[10] * q2 + C[8]) * q2 + C[6]) * q2 + C[4]) * q2 + C[2], o = (((C[9] * q2 + C[7]) * q2 + C[5]) * q2 + C[3]) * q2 + C[1];
    *c = e * q + o;
    e = (((S[10] * q2 + S[8]) * q2 + S[6]) * q2 + S[4]) * q2 + S[2], o = (((S[9] * q2 + S[7]) * q2 + S[5]) * q2 + S[3]) * q2 + S[1];
    *s = (e * q + o) * q + S[0];
}
IN Clock clock_at(const Con *c, double hi, double lo, double phase)
{
    V x = phase - (V){0}, halves = whole(2.0 * x), r = x - 0.5 * halves, odd = halves - 2.0 * whole(0.5 * halves), sign = 1.0 - 2.0 * odd * odd;
    V q = r * r, cos, sin;
    polynomials(q, &cos, &sin);
    return (Clock){hi, lo, phase, c->speed + c->speed_rate * (hi + lo), (sign * (q * cos + 1.0))[0], (sign * r * sin)[0]};
}
typedef struct { V re, im, omega, cos, sin; } Turns;
IN Turns turns_after(const Con *c, const Clock *from, V tau)
{
    V angle = tau * (0.5 * c->speed_rate * tau + from->speed), square = angle * angle, cos, sin;
    polynomials(square, &cos, &sin);
    cos = square * cos, sin = angle * sin; /* cosine of the angle less one, and its sine */
    Turns t;
    t.cos = (cos * from->cos + from->cos) - sin * from->sin, t.sin = sin * from->cos + (cos * from->sin + from->sin);
    t.omega = TP * (c->speed_rate * tau + from->speed);
    V omega2 = t.omega * t.omega;
    double omega_dot = TP * c->speed_rate;
    t.re = omega2 * t.cos + omega_dot * t.sin, t.im = omega2 * t.sin - omega_dot * t.cos;
    return t;
}
IN Turn pick(const Turns *t, int i) { return (Turn){t->re[i], t->im[i], t->omega[i], t->cos[i], t->sin[i]}; }
IN Turn turn_of(const Con *c, const Clock *k)
{
    double omega = TP * k->speed, omega2 = omega * omega, omega_dot = TP * c->speed_rate;
    return (Turn){omega2 * k->cos + omega_dot * k->sin, omega2 * k->sin - omega_dot * k->cos, omega, k->cos, k->sin};
}
IN Clock ahead(const Con *c, Clock k, double h)
{
    double hi = k.hi + h, part = hi - k.hi, lo = k.lo + ((k.hi - (hi - part)) + (h - part)), top = hi + lo;
    double phase = k.phase + (k.speed + 0.5 * c->speed_rate * h) * h;
    return clock_at(c, top, lo - (top - hi), phase - (double)(int64_t)phase);
}

/* ---- contact */
IN void place(const Con *c, Pair d, Kin *k)
{
    k->d_y = d.y, k->d_z = d.z;
    double square = d.y * d.y + d.z * d.z;
    k->distance = sqrt(square);
    k->inverse = k->distance > 0.0 ? k->distance * (1.0 / square) : 0.0; /* root and division at once */
    k->p = k->distance - c->gap;
}
IN void motion(Pair v, Kin *k)
{
    k->tangential = (k->d_y * v.z - k->d_z * v.y) * k->inverse;
    k->along = k->d_y * v.y + k->d_z * v.z;
    k->rate = k->along * k->inverse;
    k->size = fabs(v.y) + fabs(v.z);
}
IN Kin kinematics(const Con *c, X x, X v)
{
    Kin k;
    place(c, pair_sum(mul(c->contact_row, x)), &k);
    motion(pair_sum(mul(c->contact_row, v)), &k);
    return k;
}
IN int classify(const Con *c, Kin k)
{
    if (!(k.p > 0.0)) return OPEN;
    if (c->b_c == 0.0 || k.rate >= 0.0) return CLOSING;
    return c->k_c * k.p + c->b_c * k.rate >= 0.0 ? OPENING : CLIPPED;
}
IN Law law_of(const Con *c, int mode) { return (Law){mode == CLOSING || mode == OPENING ? c->k_c : 0.0, mode == OPENING ? c->b_c : 0.0}; }
IN int stays(const Con *c, int mode, const Kin *k)
{
    if (mode == OPEN) return k->p <= 0.0;
    double force = c->k_c * k->p + c->b_c * k->rate;
    if (mode == CLIPPED) return k->p >= 0.0 && force <= 0.0;
    if (mode == OPENING) return k->rate <= 0.0 && force >= 0.0;
    return k->p >= 0.0 && (c->b_c == 0.0 || k->rate >= 0.0);
}
IN double margin(const Con *c, int mode, Kin k)
{
    double opening = k.distance > 0.0 ? -k.p * k.inverse : 1.0;
    if (mode == OPEN) return opening;
    double receding = k.size > 0.0 ? -k.rate / k.size : 0.0;
    double force = (c->k_c * k.p + c->b_c * k.rate) / (c->k_c * k.distance + c->b_c * k.size);
    if (mode == CLIPPED) return fmin(-opening, -force);
    if (mode == OPENING) return fmin(receding, force);
    return c->b_c == 0.0 ? -opening : fmin(-opening, -receding);
}

/* ---- one stage: time * x'' */
IN X times_columns(const X *columns, X v)
{
    X r = spread(0.0);
#pragma GCC unroll 64
    for (int i = 0; i < N; i++) {
        int at = 2 * i % W;
        VI pair = (VI){0} + at + ((VI)IOTA & 1);
        V both = __builtin_shuffle(v.b[2 * i / W], pair);
        EACH r.b[j] += columns[i].b[j] * both;
    }
    return r;
}
typedef struct { X stiffness, damping; double time; Law law; } Field;
IN Field field_of(const Con *c, Law law, double time)
{
    return (Field){scale(time, c->stiffness), scale(time, c->damping), time, {time * law.k, time * law.b}};
}
IN X accelerations(const Con *c, const Field *f, X x, X v, Turn t, Powers *w, Kin *k)
{
    X imposed = plus(t.re, c->unbalance, plus(t.im, c->i_unbalance, c->load));
#ifdef GYRO
    double omega_dot = TP * c->speed_rate;
    imposed = plus(omega_dot * t.sin, c->euler, plus(-omega_dot * t.cos, c->i_euler, imposed));
#endif
    imposed = scale(f->time, imposed);
    X damping = mul(f->damping, v);
#ifdef FULL
    damping = plus(f->time, times_columns(c->damping_columns, v), damping);
#endif
    X a = add(fma_(f->stiffness, x, imposed), damping);
#ifdef GYRO
    a = plus(f->time * t.omega, times_i(times_columns(c->gyroscopic_columns, v)), a);
#endif
    if (f->law.k > 0.0) {
        place(c, pair_sum(mul(c->contact_row, x)), k);
        motion(pair_sum(mul(c->contact_row, v)), k);
        double per_length = f->law.k - f->law.k * c->gap * k->inverse, lost = 0.0;
        if (f->law.b > 0.0) per_length += f->law.b * k->inverse * k->inverse * k->along, lost = f->law.b * k->rate * k->rate;
        a = plus(per_length, mul(c->force_row, fill(k->d_y - c->mu * k->d_z, k->d_z + c->mu * k->d_y)), a);
        w->contact = lost, w->friction = -c->mu * per_length * k->distance * k->tangential;
    } else {
        w->contact = w->friction = 0.0;
    }
#ifdef LEDGER
#ifdef COUPLED
    w->damping = mul(v, damping);
#endif
    w->drive = mul(v, imposed);
#endif
    return a;
}

/* ---- one step */
typedef struct { X a1, a3, a4, a5, a6, a7; } Stages;
typedef struct { State new; Stages s; Powers work; double h; } Step;
#define A21 (1. / 5)
#define A31 (3. / 40)
#define A32 (9. / 40)
#define A41 (44. / 45)
#define A42 (-56. / 15)
#define A43 (32. / 9)
#define A51 (19372. / 6561)
#define A52 (-25360. / 2187)
#define A53 (64448. / 6561)
#define A54 (-212. / 729)
#define A61 (9017. / 3168)
#define A62 (-355. / 33)
#define A63 (46732. / 5247)
#define A64 (49. / 176)
#define A65 (-5103. / 18656)
#define B1 (35. / 384)
#define B3 (500. / 1113)
#define B4 (125. / 192)
#define B5 (-2187. / 6784)
#define B6 (11. / 84)
#define E1 (71. / 57600)
#define E3 (-71. / 16695)
#define E4 (71. / 1920)
#define E5 (-17253. / 339200)
#define E6 (22. / 525)
#define E7 (-1. / 40)
#define D1 (-12715105075. / 11282082432)
#define D3 (87487479700. / 32700410799)
#define D4 (-10690763975. / 1880347072)
#define D5 (701980252875. / 199316789632)
#define D6 (-1453857185. / 822651844)
#define D7 (69997945. / 29380423)
/* the same for positions, by the accelerations alone (rsc.kernel.tableau.Positions) */
#define AFTER1(w2, w3, w4, w5, w6, w7) ((w2) * A21 + (w3) * A31 + (w4) * A41 + (w5) * A51 + (w6) * A61 + (w7) * B1)
#define AFTER2(w3, w4, w5, w6) ((w3) * A32 + (w4) * A42 + (w5) * A52 + (w6) * A62)
#define AFTER3(w4, w5, w6, w7) ((w4) * A43 + (w5) * A53 + (w6) * A63 + (w7) * B3)
#define AFTER4(w5, w6, w7) ((w5) * A54 + (w6) * A64 + (w7) * B4)
#define AFTER5(w6, w7) ((w6) * A65 + (w7) * B5)
IN X row3(X base, double c3, X k3, double c2, X k2, double c1, X k1) { return plus(c3, k3, plus(c2, k2, plus(c1, k1, base))); }

/* what a step needs that depends on nothing but time */
typedef struct { double h; Clock end; Turns turns; } Plan;
IN Plan plan_of(const Con *c, Clock from, double h)
{
    Clock end = ahead(c, from, h);
    if (h >= (c->end - from.hi) - from.lo) end = clock_at(c, c->end, 0.0, end.phase);
    static const double nodes[8] = {0.2, 0.3, 0.8, 8. / 9};
    V tau;
    memcpy(&tau, nodes, sizeof tau);
    return (Plan){h, end, turns_after(c, &from, h * tau)};
}
IN void attempt(const Con *c, Law law, const State *from, const Plan *plan, Step *out)
{
    double h = plan->h;
    Clock end = plan->end;
    Turns turns = plan->turns;
    Turn last = turn_of(c, &end);
    Field f = field_of(c, law, h), one = field_of(c, law, 1.0);
    X x = from->x, v = from->v, a1 = scale(h, from->a), s, u;
    Powers p1 = from->w, p2, p3, p4, p5, p6;
    Kin k;
    s = plus(h, scale(1. / 5, v), x), u = plus(A21, a1, v);
    X a2 = accelerations(c, &f, s, u, pick(&turns, 0), &p2, &k);
    s = plus(h, plus(AFTER1(A32, 0, 0, 0, 0, 0), a1, scale(3. / 10, v)), x), u = plus(A32, a2, plus(A31, a1, v));
    X a3 = accelerations(c, &f, s, u, pick(&turns, 1), &p3, &k);
    s = plus(AFTER2(A43, 0, 0, 0), a2, plus(AFTER1(A42, A43, 0, 0, 0, 0), a1, scale(4. / 5, v)));
    s = plus(h, s, x), u = row3(v, A43, a3, A42, a2, A41, a1);
    X a4 = accelerations(c, &f, s, u, pick(&turns, 2), &p4, &k);
    s = row3(scale(8. / 9, v), AFTER3(A54, 0, 0, 0), a3, AFTER2(A53, A54, 0, 0), a2, AFTER1(A52, A53, A54, 0, 0, 0), a1);
    s = plus(h, s, x), u = plus(A54, a4, row3(v, A53, a3, A52, a2, A51, a1));
    X a5 = accelerations(c, &f, s, u, pick(&turns, 3), &p5, &k);
    s = row3(v, AFTER3(A64, A65, 0, 0), a3, AFTER2(A63, A64, A65, 0), a2, AFTER1(A62, A63, A64, A65, 0, 0), a1);
    s = plus(h, plus(AFTER4(A65, 0, 0), a4, s), x), u = plus(A65, a5, plus(A64, a4, row3(v, A63, a3, A62, a2, A61, a1)));
    X a6 = accelerations(c, &f, s, u, last, &p6, &k);
    State *new = &out->new;
    s = row3(v, AFTER4(B5, B6, 0), a4, AFTER3(B4, B5, B6, 0), a3, AFTER1(0, B3, B4, B5, B6, 0), a1);
    X mean = plus(AFTER5(B6, 0), a5, s);
    new->x = plus(h, mean, x);
    new->v = plus(B6, a6, plus(B5, a5, row3(v, B4, a4, B3, a3, B1, a1)));
    new->a = accelerations(c, &one, new->x, new->v, last, &new->w, &new->kin);
    if (!(law.k > 0.0)) new->kin = kinematics(c, new->x, new->v);
    new->clock = end;
    out->h = h;
    out->s = (Stages){a1, a3, a4, a5, a6, scale(h, new->a)};
    Powers *w = &out->work;
#ifdef LEDGER
#ifdef COUPLED
    w->damping = plus(B6, p6.damping, plus(B5, p5.damping, plus(B4, p4.damping, plus(B3, p3.damping, scale(h * B1, p1.damping)))));
#else
    X first = plus(-1. / 12, add(a1, out->s.a7), plus(-1., v, new->v)), second = plus(-2., mean, add(v, new->v)); /* rsc.kernel.losses */
    w->damping = mul(f.damping, fma_(scale(0.05, second), second, fma_(scale(0.12, first), first, mul(mean, mean))));
#endif
    w->drive = plus(B6, p6.drive, plus(B5, p5.drive, plus(B4, p4.drive, plus(B3, p3.drive, scale(h * B1, p1.drive)))));
#endif
    w->contact = h * B1 * p1.contact + B3 * p3.contact + B4 * p4.contact + B5 * p5.contact + B6 * p6.contact;
    w->friction = h * B1 * p1.friction + B3 * p3.friction + B4 * p4.friction + B5 * p5.friction + B6 * p6.friction;
}
IN X weighted(X a1, double c1, X a3, double c3, X a4, double c4, X a5, double c5, X a6, double c6)
{
    return plus(c6, a6, plus(c5, a5, plus(c4, a4, plus(c3, a3, scale(c1, a1)))));
}
#define OF_X(w1, w3, w4, w5, w6, w7, s) weighted((s)->a1, AFTER1(0, w3, w4, w5, w6, w7), (s)->a3, AFTER3(w4, w5, w6, w7), \
    (s)->a4, AFTER4(w5, w6, w7), (s)->a5, AFTER5(w6, w7), (s)->a6, (w7) * B6)
#define OF_V(w1, w3, w4, w5, w6, w7, s) \
    plus(w7, (s)->a7, weighted((s)->a1, w1, (s)->a3, w3, (s)->a4, w4, (s)->a5, w5, (s)->a6, w6))
#define ERROR E1, E3, E4, E5, E6, E7
#define DENSE D1, D3, D4, D5, D6, D7
#define EXPANDED(of, ...) of(__VA_ARGS__)
IN double error_square(const Con *c, const State *from, const Stages *s, double h)
{
    X w_x = add(c->scale_x, pair_square(from->x)), w_v = add(c->scale_v, pair_square(from->v));
    EACH w_x.b[j] = c->per_rtol2 / w_x.b[j], w_v.b[j] = c->per_rtol2 / w_v.b[j];
    X e_x = mul(pair_square(scale(h, EXPANDED(OF_X, ERROR, s))), w_x);
    X e_v = mul(pair_square(EXPANDED(OF_V, ERROR, s)), w_v);
    EACH e_x.b[j] = larger((V)((VI)e_x.b[j] & INT64_MAX), (V)((VI)e_v.b[j] & INT64_MAX));
    return largest(e_x);
}
IN X quartic(X y0, X y1, X slope0, X slope1, X last, double theta)
{
    X rise = plus(-1.0, y0, y1), bend = plus(-1.0, rise, slope0), twist = plus(-1.0, bend, plus(-1.0, slope1, rise));
    return plus(theta, plus(1.0 - theta, plus(theta, plus(1.0 - theta, last, twist), bend), rise), y0);
}
IN Kin inside(const Con *c, const State *from, const Step *p, double theta, X *x)
{
    const Stages *s = &p->s;
    double h = p->h;
    *x = quartic(from->x, p->new.x, scale(h, from->v), scale(h, p->new.v), scale(h, EXPANDED(OF_X, DENSE, s)), theta);
    return kinematics(c, *x, quartic(from->v, p->new.v, s->a1, s->a7, EXPANDED(OF_V, DENSE, s), theta));
}

/* ---- switches: the length to try instead, 0 to take the step */
#define EPS 2.220446049250313e-16
static double root_inside(const Con *c, int mode, const State *from, const Step *p, double g_near, double far, double g_far, double g_tol)
{
    double near = 0.0, theta = far;
    int side = 0;
    X x;
    for (int i = 0; i < 40; i++) {
        int begins = near == 0.0 && g_near < -0.1 * g_far;
        theta = begins ? 0.5 * far : near + (far - near) * g_near / (g_near - g_far);
        double g = margin(c, mode, inside(c, from, p, theta, &x)), share;
        if ((-g_tol <= g && g <= fmin(g_tol, g_near)) || far - near <= 8.0 * EPS) break;
        if (g > 0.0) {
            share = 1.0 - g / g_near, near = theta, g_near = g;
            if (side == 1) g_far *= share > 0.0 ? share : 0.5;
            side = 1;
        } else {
            share = 1.0 - g / g_far, far = theta, g_far = g;
            if (side == -1 && !begins) g_near *= share > 0.0 ? share : 0.5;
            side = -1;
        }
    }
    return theta;
}
IN double defect2(const Con *c, double force, double tau, X v)
{
    X reach = mul(c->force_row, c->force_row), v2 = add(c->scale_v, pair_square(v));
    EACH reach.b[j] /= v2.b[j];
    return force * tau * force * tau * largest(reach);
}
static double wrong_force(const Con *c, int mode, Kin k)
{
    if (mode == CLIPPED) return c->k_c * fabs(k.p);
    Law law = law_of(c, mode), other = law_of(c, classify(c, k));
    double difference = (law.k - other.k) * k.p + (law.b - other.b) * k.rate;
    return fabs(difference) * sqrt(1.0 + c->mu * c->mu);
}
#define LOOKS 6
static double extremum(const Con *c, const State *from, const Step *p, double a, double b, double f_a, double f_b)
{
    double all = fabs(f_a) + fabs(f_b), theta = a;
    X x;
    for (int i = 0; i < 20; i++) {
        theta = a + (b - a) * f_a / (f_a - f_b);
        double rate = inside(c, from, p, theta, &x).rate;
        if (fabs(rate) <= 1e-9 * all) break;
        if ((rate > 0.0) == (f_a > 0.0)) a = theta, f_a = rate, f_b *= 0.5;
        else b = theta, f_b = rate, f_a *= 0.5;
    }
    return theta;
}
/* longest time for which a quantity may have been negative that is so at a step's end */
IN double time_beyond(double value, double slope) { return value >= 0.0 ? 0.0 : slope < 0.0 ? 2.0 * value / slope : INFINITY; }
static double longest_tau(const Con *c, int mode, const State *new)
{
    const Kin *k = &new->kin;
    if (mode == CLIPPED) return INFINITY;
    if (mode == OPEN) return time_beyond(-k->p, -k->rate);
    Pair a = pair_sum(mul(c->contact_row, new->a));
    double slope = (k->d_y * a.y + k->d_z * a.z + k->tangential * k->tangential) * k->inverse;
    if (mode == CLOSING) {
        double tau = time_beyond(k->p, k->rate);
        return c->b_c == 0.0 ? tau : fmax(tau, time_beyond(k->rate, slope));
    }
    return fmax(time_beyond(-k->rate, -slope), time_beyond(c->k_c * k->p + c->b_c * k->rate, c->k_c * k->rate + c->b_c * slope));
}
static double tolerance_of(const Con *c, double g_far, double d2)
{
    return 1e-3 * fabs(g_far) * sqrt(fmin(0.1 * c->switch_tol / sqrt(d2), 0.01));
}
static __attribute__((noinline)) double search(const Con *c, int mode, const State *from, const Step *p, double h)
{
    double tol2 = c->switch_tol * c->switch_tol, g_end = margin(c, mode, p->new.kin), g_near = fmax(margin(c, mode, from->kin), 0.0);
    double theta, behind, least = 16.0 * EPS * (from->clock.hi + h);
    if (g_end < 0.0) {
        double force = 0.5 * wrong_force(c, mode, p->new.kin);
        if (defect2(c, force, longest_tau(c, mode, &p->new), p->new.v) <= tol2) return 0.0;
        theta = root_inside(c, mode, from, p, g_near, 1.0, g_end, tolerance_of(c, g_end, defect2(c, force, h, p->new.v)));
        double tau = (1.0 - theta) * h, d2 = defect2(c, force, tau, p->new.v);
        if (d2 <= tol2) return 0.0;
        behind = fmin(tau * sqrt(0.1 * c->switch_tol / sqrt(d2)), 0.1 * tau);
    } else {
        /* the rate is looked at in several places: a long step may recede, touch and recede again */
        double sign = mode == OPEN ? 1.0 : -1.0, before = 0.0, rate_before = from->kin.rate, far = 0.0, g_far = 0.0;
        Kin k = from->kin;
        X x;
        for (int look = 1; look <= LOOKS; look++) {
            double at = (double)look / LOOKS, rate = inside(c, from, p, at, &x).rate;
            if (sign * rate_before > 0.0 && sign * rate < 0.0) {
                far = extremum(c, from, p, before, at, rate_before, rate);
                k = inside(c, from, p, far, &x), g_far = margin(c, mode, k);
                if (g_far < 0.0) break;
            }
            before = at, rate_before = rate, far = 0.0;
        }
        if (far == 0.0) return 0.0;
        double force = 2.0 * c->k_c * fabs(k.p);
        theta = root_inside(c, mode, from, p, g_near, far, g_far, tolerance_of(c, g_far, defect2(c, force, h, p->new.v)));
        double tau = (far - theta) * h;
        if (defect2(c, force, tau, p->new.v) <= tol2) return 0.0;
        behind = 0.1 * tau;
    }
    double h_new = theta * h + fmax(behind, least);
    return h_new < h ? h_new : 0.0;
}
IN int may_touch(int mode, const Kin *k, const Kin *new, double h)
{
    double reach = h * fmax(fabs(k->rate), fabs(new->rate));
    if (mode == OPEN) return fmax(k->p, new->p) + reach > 0.0;
    return k->rate < 0.0 && new->rate > 0.0 && fmin(k->p, new->p) - reach < 0.0;
}

/* ---- control */
IN double factor(double error2)
{
    if (!(error2 < 1e8)) return 0.2;
    int64_t bits;
    memcpy(&bits, &error2, 8);
    double log2 = fmax((double)bits * 0x1p-52 - 1023.0, -40.0), power = 0.1 * (-2.321928094887362 - log2);
    double z = fmin(fmax(power, -2.3), 2.3) * (0.6931471805599453 / 8.0), t = 1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0)));
    t *= t, t *= t;
    return t * t;
}
static __attribute__((noinline)) long save(const Con *c, Law law, double *out, long sample, const State *from, const Step *p, double h)
{
    const Clock *end = &p->new.clock, *start = &from->clock;
    for (double time = sample / c->rate; (time - end->hi) - end->lo <= 0.0; time = ++sample / c->rate) {
        double theta = fmin(fmax(((time - start->hi) - start->lo) / h, 0.0), 1.0);
        X x;
        Kin k = inside(c, from, p, theta, &x);
        double force = law.k * k.p + law.b * k.rate, *row = out + sample * (L + 3);
        store(row, x);
        row[L] = force > 0.0 ? force : 0.0, row[L + 1] = row[L] * c->mu, row[L + 2] = k.tangential;
    }
    return sample;
}

/* vectors: (13, L) in the order below; numbers: gap mu k_c b_c switch_tol rtol h_max divergence rate end speed speed_rate h;
   state: x (L), v (L); counts: steps, rejected, attempts, switches; energies: contact, friction, then damping (L), drive (L) */
int dp5(const double *vectors, const double *columns, const double *numbers, const double *state, double *out, long *counts, double *energies)
{
    Con con, *c = &con;
    X *parts[] = {&con.stiffness, &con.damping, &con.contact_row, &con.force_row, &con.unbalance, &con.euler, &con.load, &con.scale_x, &con.scale_v};
    for (int i = 0; i < 9; i++) *parts[i] = load(vectors + i * L);
    for (int i = L; i < NB * W; i++) con.scale_x.b[NB - 1][i % W] = con.scale_v.b[NB - 1][i % W] = 1.0;
    con.i_unbalance = times_i(con.unbalance), con.i_euler = times_i(con.euler);
    for (int i = 0; i < N; i++) con.damping_columns[i] = load(columns + i * L), con.gyroscopic_columns[i] = load(columns + (N + i) * L);
    con.gap = numbers[0], con.mu = numbers[1], con.k_c = numbers[2], con.b_c = numbers[3], con.switch_tol = numbers[4];
    con.per_rtol2 = 1.0 / (numbers[5] * numbers[5]), con.h_max = numbers[6], con.divergence2 = numbers[7] * numbers[7];
    con.rate = numbers[8], con.end = numbers[9], con.speed = numbers[10], con.speed_rate = numbers[11];
    double h = numbers[12], h_search = 0.0, h_next = h;
    State now = {.x = load(state), .v = load(state + L), .clock = clock_at(c, 0.0, 0.0, 0.0)};
    now.kin = kinematics(c, now.x, now.v);
    int mode = classify(c, now.kin), tries = 0, code;
    Law law = law_of(c, mode);
    Step step;
    Kin unused;
    long steps = 0, rejected = 0, attempts = 0, switches = 0, sample = 0;
    double sample_time = 0.0, e_contact = 0.0, e_friction = 0.0;
    X e_damping = spread(0.0), e_drive = spread(0.0);
#define ENTER(s) do { Field f = field_of(c, law, 1.0); \
        (s).a = accelerations(c, &f, (s).x, (s).v, turn_of(c, &(s).clock), &(s).w, &unused); } while (0)
    ENTER(now);
    Plan plan = plan_of(c, now.clock, h);
    for (;;) {
        double left = (con.end - now.clock.hi) - now.clock.lo, h_try = h_search > 0.0 ? h_search : fmin(h, left);
        if (!(h_search > 0.0) && !(h >= fmax(10.0 * EPS * now.clock.hi, 1e-290))) { code = COLLAPSED; break; }
        attempts++;
        if (plan.h != h_try) plan = plan_of(c, now.clock, h_try);
        /* rotations take long and wait for nothing: those of the next step, should it be as long, are begun before this one */
        Plan next = plan_of(c, plan.end, h_try);
        attempt(c, law, &now, &plan, &step);
        double error2 = error_square(c, &now, &step.s, step.h);
        if (!LIKELY(error2 <= 1.0)) {
            rejected++;
            h = h_try * fmin(factor(error2), 0.9), h_search = 0.0, tries = 0;
            continue;
        }
        if (!(h_search > 0.0)) {
            h_next = h;
            if (!(0.2 < error2 && error2 < 0.5 && h_try == h)) {
                double next = fmin(h_try * factor(error2), con.h_max);
                h_next = h_try < h ? fmax(h, next) : next;
            }
        }
        int stay = stays(c, mode, &step.new.kin);
        h_search = 0.0;
        if ((!stay || may_touch(mode, &now.kin, &step.new.kin, h_try)) && tries < 16) h_search = search(c, mode, &now, &step, h_try);
        if (h_search > 0.0) { tries++; continue; }
        tries = 0;
        if ((sample_time - step.new.clock.hi) - step.new.clock.lo <= 0.0) sample = save(c, law, out, sample, &now, &step, h_try), sample_time = sample / con.rate;
#ifdef LEDGER
        e_damping = add(e_damping, step.work.damping), e_drive = add(e_drive, step.work.drive);
        if (mode != OPEN) e_contact += step.work.contact, e_friction += step.work.friction;
        if (mode == CLIPPED) e_contact += 0.5 * con.k_c * (now.kin.p * now.kin.p - fmax(step.new.kin.p, 0.0) * fmax(step.new.kin.p, 0.0));
#endif
        steps++;
        now = step.new, plan = next;
        h = h_next;
        if (h_try >= left) { code = FINISHED; break; }
        if (!stay) {
            mode = classify(c, now.kin), law = law_of(c, mode), switches++;
            ENTER(now);
            plan = plan_of(c, now.clock, h);
        }
        if (!(largest(pair_square(now.x)) <= con.divergence2)) { code = DIVERGED; break; }
    }
    counts[0] = steps, counts[1] = rejected, counts[2] = attempts, counts[3] = switches;
    energies[0] = e_contact, energies[1] = e_friction;
    store(energies + 2, e_damping), store(energies + 2 + L, e_drive);
    return code;
}
