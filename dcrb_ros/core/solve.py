"""Mean velocities of bound rollers between the bodies that they touch, and what they do to these."""

from __future__ import annotations

from dcrb_ros.core import lanes as at
from dcrb_ros.core.jit import piece
from dcrb_ros.core.payload import Payload
from dcrb_ros.core.state import CAGE, INNER, OUTER
from dcrb_ros.core.work import Workspace


@piece
def prepare_bound(payload: Payload, work: Workspace, count: int) -> None:
    """Write how rollers between both raceways and a bar yield, which does not depend on the bodies' velocities."""
    near, h = work.bound, payload.step
    mass, inertia = 2.0 * payload.roller_mass, 2.0 * payload.roller_inertia / (payload.roller_radius * payload.roller_radius)
    for k in range(count):
        inx, iny = near[at.INNER + at.NORMAL_X + k], near[at.INNER + at.NORMAL_Y + k]
        itx, ity = -near[at.INNER + at.RADIAL_Y + k], near[at.INNER + at.RADIAL_X + k]
        ig, il = near[at.INNER + at.GIVE + k], near[at.INNER + at.SLOPE + k]
        ip, ic = near[at.INNER + at.PUSH + k], near[at.INNER + at.CONSTANT + k]
        onx, ony = near[at.OUTER + at.NORMAL_X + k], near[at.OUTER + at.NORMAL_Y + k]
        otx, oty = -near[at.OUTER + at.RADIAL_Y + k], near[at.OUTER + at.RADIAL_X + k]
        og, ol = near[at.OUTER + at.GIVE + k], near[at.OUTER + at.SLOPE + k]
        op, oc = near[at.OUTER + at.PUSH + k], near[at.OUTER + at.CONSTANT + k]
        bnx, bny, sign = near[at.TAU_X + k], near[at.TAU_Y + k], near[at.BAR + at.AHEAD + k]
        btx, bty = bny, -bnx
        bg, bl = near[at.BAR + at.GIVE + k], near[at.BAR + at.SLOPE + k]
        bp, bc = sign * near[at.BAR + at.PUSH + k], near[at.BAR + at.CONSTANT + k]

        near[at.REST_X + k] = mass * near[at.ALONE_X + k] + h * (ip * inx - ic * itx - op * onx - oc * otx - bp * bnx - bc * btx)
        near[at.REST_Y + k] = mass * near[at.ALONE_Y + k] + h * (ip * iny - ic * ity - op * ony - oc * oty - bp * bny - bc * bty)
        near[at.REST_RIM + k] = inertia * near[at.ALONE_RIM + k] + h * (ic - oc + sign * bc)
        xx = mass + h * (ig * inx * inx + il * itx * itx + og * onx * onx + ol * otx * otx + bg * bnx * bnx + bl * btx * btx)
        xy = h * (ig * inx * iny + il * itx * ity + og * onx * ony + ol * otx * oty + bg * bnx * bny + bl * btx * bty)
        yy = mass + h * (ig * iny * iny + il * ity * ity + og * ony * ony + ol * oty * oty + bg * bny * bny + bl * bty * bty)
        xw, yw = h * (ol * otx - il * itx - sign * bl * btx), h * (ol * oty - il * ity - sign * bl * bty)
        by_w = 1.0 / (inertia + h * (il + ol + bl))
        xx, xy, yy = xx - by_w * xw * xw, xy - by_w * xw * yw, yy - by_w * yw * yw
        by_determinant = 1.0 / (xx * yy - xy * xy)
        near[at.YIELD_XX + k], near[at.YIELD_YY + k] = yy * by_determinant, xx * by_determinant
        near[at.YIELD_XY + k], near[at.YIELD_RIM + k] = -xy * by_determinant, by_w
        near[at.COUPLED_X + k], near[at.COUPLED_Y + k] = by_w * xw, by_w * yw


@piece
def solve_bound(payload: Payload, work: Workspace, count: int, surface: float) -> None:
    """Solve for rollers between both raceways and a bar, at the present mean velocities of rings and cages.

    A pinned roller moves with its cage and turns by itself. ``surface`` is the speed of the inner ring's surface [m/s].
    """
    near, h, pitch = work.bound, payload.step, payload.pitch_radius
    inner_x, inner_y, outer_x, outer_y = work.mean[INNER, 0], work.mean[INNER, 1], work.mean[OUTER, 0], work.mean[OUTER, 1]
    last = work.mean.shape[0] - 1
    first_x, first_y, first_turn = work.mean[CAGE, 0], work.mean[CAGE, 1], work.mean[CAGE, 2]
    second_x, second_y, second_turn = work.mean[last, 0], work.mean[last, 1], work.mean[last, 2]
    for k in range(count):
        second = near[at.SECOND + k] > 0.0
        own_x, own_y, turn = second_x if second else first_x, second_y if second else first_y, second_turn if second else first_turn
        # Per contact: normal n, tangent t, and the velocity of the body there along both.
        inx, iny = near[at.INNER + at.NORMAL_X + k], near[at.INNER + at.NORMAL_Y + k]
        itx, ity = -near[at.INNER + at.RADIAL_Y + k], near[at.INNER + at.RADIAL_X + k]
        ig, il = near[at.INNER + at.GIVE + k], near[at.INNER + at.SLOPE + k]
        ipn, ipt = inner_x * inx + inner_y * iny + near[at.INNER + at.SURFACE_N + k], inner_x * itx + inner_y * ity + surface
        onx, ony = near[at.OUTER + at.NORMAL_X + k], near[at.OUTER + at.NORMAL_Y + k]
        otx, oty = -near[at.OUTER + at.RADIAL_Y + k], near[at.OUTER + at.RADIAL_X + k]
        og, ol = near[at.OUTER + at.GIVE + k], near[at.OUTER + at.SLOPE + k]
        opn, opt = outer_x * onx + outer_y * ony, outer_x * otx + outer_y * oty
        bnx, bny, sign = near[at.TAU_X + k], near[at.TAU_Y + k], near[at.BAR + at.AHEAD + k]
        btx, bty = bny, -bnx
        bg, bl = near[at.BAR + at.GIVE + k], near[at.BAR + at.SLOPE + k]
        lever_x, lever_y = near[at.BAR + at.LEVER_X + k], near[at.BAR + at.LEVER_Y + k]
        cage_x, cage_y = own_x - turn * lever_y, own_y + turn * lever_x
        bpn, bpt = cage_x * bnx + cage_y * bny, cage_x * btx + cage_y * bty

        i_push, i_hold, o_push, o_hold, b_push, b_hold = ig * ipn, il * ipt, og * opn, ol * opt, bg * bpn, bl * bpt
        w = near[at.REST_RIM + k] + h * (o_hold - i_hold - sign * b_hold)
        coupled_x, coupled_y = near[at.COUPLED_X + k], near[at.COUPLED_Y + k]
        x = i_push * inx + i_hold * itx + o_push * onx + o_hold * otx + b_push * bnx + b_hold * btx
        y = i_push * iny + i_hold * ity + o_push * ony + o_hold * oty + b_push * bny + b_hold * bty
        x, y = near[at.REST_X + k] + h * x - coupled_x * w, near[at.REST_Y + k] + h * y - coupled_y * w
        free_x = near[at.YIELD_XX + k] * x + near[at.YIELD_XY + k] * y
        free_y = near[at.YIELD_XY + k] * x + near[at.YIELD_YY + k] * y
        moving = near[at.MOVING + k] > 0.0
        mean_x = free_x if moving else own_x + pitch * turn * bnx
        mean_y = free_y if moving else own_y + pitch * turn * bny
        rim = near[at.YIELD_RIM + k] * w - coupled_x * mean_x - coupled_y * mean_y
        near[at.MEAN_X + k], near[at.MEAN_Y + k], near[at.MEAN_RIM + k] = mean_x, mean_y, rim

        i_normal = near[at.INNER + at.PUSH + k] + i_push - ig * (mean_x * inx + mean_y * iny)
        i_friction = near[at.INNER + at.CONSTANT + k] - i_hold + il * (mean_x * itx + mean_y * ity - rim)
        o_normal = near[at.OUTER + at.PUSH + k] - o_push + og * (mean_x * onx + mean_y * ony)
        o_friction = near[at.OUTER + at.CONSTANT + k] - o_hold + ol * (mean_x * otx + mean_y * oty + rim)
        b_normal = b_push - sign * near[at.BAR + at.PUSH + k] - bg * (mean_x * bnx + mean_y * bny)
        b_friction = near[at.BAR + at.CONSTANT + k] - b_hold + bl * (mean_x * btx + mean_y * bty - sign * rim)
        fix, fiy = i_normal * inx - i_friction * itx, i_normal * iny - i_friction * ity
        fox, foy = -o_normal * onx - o_friction * otx, -o_normal * ony - o_friction * oty
        fbx, fby = b_normal * bnx - b_friction * btx, b_normal * bny - b_friction * bty
        carried_x, carried_y = 0.0 if moving else fix + fox, 0.0 if moving else fiy + foy
        near[at.ON_INNER_X + k], near[at.ON_INNER_Y + k] = -fix, -fiy
        near[at.ON_OUTER_X + k], near[at.ON_OUTER_Y + k] = -fox, -foy
        near[at.ON_CAGE_X + k], near[at.ON_CAGE_Y + k] = carried_x - fbx, carried_y - fby
        near[at.ON_CAGE_TURN + k] = pitch * (carried_x * bnx + carried_y * bny) - lever_x * fby + lever_y * fbx


@piece
def push_bound(payload: Payload, work: Workspace) -> None:
    """Write what bound rollers do to rings and cages, row by row so that rows that are alike stay alike."""
    near, k = work.bound, 0
    for body in range(work.tight.shape[0]):
        work.tight[body, 0] = work.tight[body, 1] = work.tight[body, 2] = 0.0
    for row in range(payload.free.shape[0]):
        ix, iy, ox, oy, cx, cy, turn = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        while k < work.ends[row]:
            ix += near[at.ON_INNER_X + k]
            iy += near[at.ON_INNER_Y + k]
            ox += near[at.ON_OUTER_X + k]
            oy += near[at.ON_OUTER_Y + k]
            cx += near[at.ON_CAGE_X + k]
            cy += near[at.ON_CAGE_Y + k]
            turn += near[at.ON_CAGE_TURN + k]
            k += 1
        work.tight[INNER, 0] += ix
        work.tight[INNER, 1] += iy
        work.tight[OUTER, 0] += ox
        work.tight[OUTER, 1] += oy
        work.tight[CAGE + row, 0], work.tight[CAGE + row, 1], work.tight[CAGE + row, 2] = cx, cy, turn
