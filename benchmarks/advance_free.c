/* The loop over free rollers (`advance_free` in `dcrb_ros/core/solver/free.py`) in C, for a comparison with a C compiler.

   The offsets of the fields are defined by `benchmarks/machine.py`, which compiles this file. */

#include <math.h>
#include <stdint.h>

struct constants {
    double step, radius, by_mass, by_inertia, fall, reach, ring_x, ring_y, mean_x, mean_y, old_x, old_y;
    double modulus, scale, loss_time, contact_damping, kinetic, static_, by_stribeck, bristle_stiffness, bristle_damping, viscous;
    double convection, width, raceway;
};

static inline int64_t bits_of(double x) { return (union { double x; int64_t bits; }){.x = x}.bits; }
static inline double float_of(int64_t bits) { return (union { double x; int64_t bits; }){.bits = bits}.x; }

#define INTEGERS 6755399441055744.0
#define INTEGER_BITS 0x4338000000000000LL
#define ROOT_HALF 0x3FE6A09E667F3BCDLL

static inline double logarithm(double x) {
    /* AVX2 shifts 64 bits without a sign only. */
    int64_t bits = bits_of(x), exponent = (int64_t)((uint64_t)(bits - ROOT_HALF + (1024LL << 52)) >> 52) - 1024;
    double mantissa = float_of(bits - (exponent << 52));
    double s = (mantissa - 1.0) / (mantissa + 1.0), z = s * s, z2 = z * z, z4 = z2 * z2;
    double low = (2.0 / 3.0 + z * (2.0 / 5.0)) + z2 * (2.0 / 7.0 + z * (2.0 / 9.0));
    double high = (2.0 / 11.0 + z * (2.0 / 13.0)) + z2 * (2.0 / 15.0 + z * (2.0 / 17.0)) + z4 * (2.0 / 19.0);
    return s * (2.0 + z * (low + z4 * high)) + (float_of(exponent + INTEGER_BITS) - INTEGERS) * 0.6931471805599453;
}

static inline double exponential(double x) {
    double held = x > -700.0 ? x : -700.0, shifted = held * 1.4426950408889634 + INTEGERS, whole = shifted - INTEGERS;
    double rest = held - whole * 0.693147180369123816490 - whole * 1.90821492927058770002e-10, r2 = rest * rest, r4 = r2 * r2;
    double low = (1.0 + rest) + r2 * (0.5 + rest * (1.0 / 6.0));
    double middle = (1.0 / 24.0 + rest * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + rest * (1.0 / 5040.0));
    double high = (1.0 / 40320.0 + rest * (1.0 / 362880.0)) + r2 * (1.0 / 3628800.0 + rest * (1.0 / 39916800.0));
    double found = (low + r4 * (middle + r4 * high)) * float_of((bits_of(shifted) - INTEGER_BITS + 1023) << 52);
    return x > -700.0 ? found : 0.0;
}

void advance_free(double *restrict own, double *restrict step, int64_t count, const struct constants *k) {
    const struct constants p = *k;
    const double by_radius = 1.0 / p.radius, h = p.step;
    for (int64_t c = 0; c < count; c++) {
        double dx = own[X + c] - p.ring_x, dy = own[Y + c] - p.ring_y;
        double distance = fmax(sqrt(dx * dx + dy * dy), 1e-12), by_distance = 1.0 / distance;
        double nx = dx * by_distance, ny = dy * by_distance, sink = step[SINK_SPEED + c], bristle = own[OUTER_TRACTION_BRISTLE + c];

        double depth = distance - p.reach - step[NOTCH_DEPTH + c], closed = depth > 1e-15 ? depth : 1e-15;
        double l = 1.0 + logarithm(closed) - logarithm(p.scale), t = ((l < -4.0 ? l : -4.0) + 22.0) * (1.0 / 18.0);
        double t2 = t * t, t4 = t2 * t2;
        double above = (25.227952610343658 - 111.70804449222039 * t) + t2 * (209.02017336824925 - 214.28786416771893 * t);
        above += t4 * ((130.31719216890709 - 47.426067396990194 * t) + t2 * (9.8533827349380200 - 1.0261529188664917 * t));
        above += t4 * t4 * 0.037774529454882129;
        double below = (1.0 - 3.6850037902163191 * t) + t2 * (5.5589025113215732 - 4.4000992016805178 * t);
        below += t4 * ((1.9413959503750688 - 0.46528432479890793 * t) + t2 * (0.053636784985261526 - 0.0020961313201773434 * t));
        double share = p.modulus * below / (above * (above - below));
        double force = depth > 0.0 ? closed * share * (above - below) : 0.0, stiffness = depth > 0.0 ? share * above : 0.0;

        double own_x = own[VX + c], own_y = own[VY + c], spin = own[SPIN + c];
        double vx = own_x + 0.5 * own[CHANGE_VX + c] - p.mean_x, vy = own_y + 0.5 * own[CHANGE_VY + c] - p.mean_y;
        double along = vy * nx - vx * ny, rim = p.radius * spin;
        double before = (own_x - p.old_x) * nx + (own_y - p.old_y) * ny, approach = vx * nx + vy * ny - sink;
        double loss = stiffness * p.loss_time + (force > 0.0 ? p.contact_damping : 0.0);
        double damping = force + loss * approach < 0.0 ? -force / approach : loss;
        double inertia = h * stiffness * (1.0 / 6.0), push = force - damping * sink - inertia * before, give = damping + inertia;
        double known = force + damping * approach;

        double slipping = along + rim + 0.5 * p.radius * own[CHANGE_SPIN + c], rolling = along * by_distance * p.raceway;
        double carried = 0.5 * p.convection * fabs(rolling) / sqrt(p.width * (force > 1e-9 ? force : 1e-9));
        double ratio = slipping * p.by_stribeck, g = p.kinetic + (p.static_ - p.kinetic) * exponential(-ratio * ratio);
        double rate = p.bristle_stiffness * fabs(slipping) / g + carried, decay = rate * h;
        double weight = 1.0 / (1.0 + decay + 0.5 * decay * decay);
        double phi = (1.0 + 0.5 * decay) * weight, psi = 0.5 * (1.0 + decay) * weight;
        double constant = known * phi * bristle * (p.bristle_stiffness - p.bristle_damping * rate);
        double slope = known * (p.bristle_stiffness * psi * h + p.bristle_damping * phi + p.viscous);

        double alone_x = own_x - p.mean_x, alone_y = own_y - p.fall - p.mean_y;
        double normal = (push + give * (alone_x * nx + alone_y * ny)) / (1.0 + p.by_mass * give);
        double friction = (constant + slope * (alone_y * nx - alone_x * ny + rim)) / (1.0 + (p.by_mass + p.by_inertia) * slope);
        double fx = normal * nx - friction * ny, fy = normal * ny + friction * nx;
        double x = alone_x - p.by_mass * fx, y = alone_y - p.by_mass * fy, turned = rim - p.by_inertia * friction;
        double slip = y * nx - x * ny + turned, closing = x * nx + y * ny - sink;
        double bent = bristle + h * phi * (slip - rate * bristle);

        double bound = step[BOUND + c], time = h * (1.0 - bound);
        step[FORCE_ON_OUTER_X + c] = (1.0 - bound) * fx;
        step[FORCE_ON_OUTER_Y + c] = (1.0 - bound) * fy;
        double change_x = 2.0 * (x + p.mean_x - own_x), change_y = 2.0 * (y + p.mean_y - own_y), change = 2.0 * (turned - rim) * by_radius;
        own[CHANGE_VX + c] = change_x;
        own[CHANGE_VY + c] = change_y;
        own[CHANGE_SPIN + c] = change;
        own[VX + c] = own_x + change_x;
        own[VY + c] = own_y + change_y;
        own[SPIN + c] = spin + change;
        own[OUTER_FORCE + c] = known;
        own[OUTER_FRICTION + c] = friction;
        own[OUTER_SLIP + c] = slip;
        own[OUTER_TRACTION_BRISTLE + c] = known > 0.0 ? bent : 0.0;
        own[FRICTION_LOSS + c] += time * friction * slip;
        own[CONTACT_LOSS + c] += time * damping * closing * closing;
        own[NOTCH_LOSS + c] += time * normal * sink;
    }
}

void advance_often(double *restrict own, double *restrict step, int64_t count, const struct constants *k, int64_t times) {
    for (int64_t n = 0; n < times; n++) advance_free(own, step, count, k);
}
