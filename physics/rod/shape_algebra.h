/* Rigid motions of numbers or of values on the tape, for rod_shape.c, which says of which:
 * SHAPE_NUMBER, SHAPE_VECTOR, SHAPE_ROTATION, and SHAPE(name) for what types and functions are
 * called. There is no guard: each includes it once. */
typedef struct SHAPE(twist) {
    SHAPE_VECTOR u, v;
} SHAPE(twist);

typedef struct SHAPE(pose) {
    SHAPE_VECTOR r;
    SHAPE_ROTATION q;
} SHAPE(pose);

/* pose exp(s twist): translation s (1 + c_2 w^ + c_3 w^ w^) v with c_k at |w|^2, rotation exp(w/2),
 * w = s u. */
static inline SHAPE(pose) SHAPE(advance)(SHAPE(pose) pose, SHAPE(twist) twist, SHAPE_NUMBER s)
{
    const SHAPE_VECTOR turn = SHAPE(times)(s, twist.u);
    const SHAPE_NUMBER square = SHAPE(dot)(turn, turn);
    const SHAPE_VECTOR once = SHAPE(cross)(turn, twist.v), again = SHAPE(cross)(turn, once);
    const SHAPE_VECTOR mean = SHAPE(add3)(twist.v, SHAPE(times)(SHAPE(stumpff)(2, square), once),
                                          SHAPE(times)(SHAPE(stumpff)(3, square), again));
    return (SHAPE(pose)){SHAPE(add)(pose.r, SHAPE(rotate)(pose.q, SHAPE(times)(s, mean))),
                         SHAPE(multiply)(pose.q, SHAPE(exp)(turn))};
}

/* [a, b] */
static inline SHAPE(twist) SHAPE(bracket)(SHAPE(twist) a, SHAPE(twist) b)
{
    return (SHAPE(twist)){SHAPE(cross)(a.u, b.u),
                          SHAPE(add)(SHAPE(cross)(a.u, b.v), SHAPE(cross)(a.v, b.u))};
}

/* x a + y b */
static inline SHAPE(twist) SHAPE(sum)(double x, SHAPE(twist) a, double y, SHAPE(twist) b)
{
    return (SHAPE(twist)){SHAPE(add)(SHAPE(scale)(a.u, x), SHAPE(scale)(b.u, y)),
                          SHAPE(add)(SHAPE(scale)(a.v, x), SHAPE(scale)(b.v, y))};
}

/* The twist of a step h of the Magnus method of order 6 with its three Gauss points (Blanes, Casas,
 * Oteo, Ros, Physics Reports 470, 2009, section 5.2, brackets of the other sign), for g' = g twist.
 */
static inline SHAPE(twist) SHAPE(step)(const SHAPE(twist) at[3], double h)
{
    const double root = sqrt(15.0) / 3 * h;
    const SHAPE(twist) ends = SHAPE(sum)(1, at[0], 1, at[2]);
    const SHAPE(twist) first = SHAPE(sum)(h, at[1], 0, at[1]);
    const SHAPE(twist) second = SHAPE(sum)(root, at[2], -root, at[0]);
    const SHAPE(twist) third = SHAPE(sum)(10 * h / 3, ends, -20 * h / 3, at[1]);
    const SHAPE(twist) turn = SHAPE(bracket)(first, second);
    const SHAPE(twist) inner = SHAPE(bracket)(first, SHAPE(sum)(2, third, -1, turn));
    const SHAPE(twist) left = SHAPE(sum)(1, SHAPE(sum)(-20, first, -1, third), -1, turn);
    const SHAPE(twist) right = SHAPE(sum)(1, second, 1.0 / 60, inner);
    const SHAPE(twist) whole = SHAPE(sum)(1, first, 1.0 / 12, third);
    return SHAPE(sum)(1, whole, -1.0 / 240, SHAPE(bracket)(left, right));
}
