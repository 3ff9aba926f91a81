"""Mean velocities of bound rollers between the bodies that they touch, and their forces on these.

`docs/explanation/solver.md` derives the equations.
"""

from __future__ import annotations

from dcrb_ros.core.jit import piece
from dcrb_ros.core.laws.calls import load_resistance
from dcrb_ros.core.laws.site import Site
from dcrb_ros.core.layout.cages import of_cages, of_row
from dcrb_ros.core.layout.state import CAGE, INNER, OUTER
from dcrb_ros.core.layout.workspace import Workspace
from dcrb_ros.core.payload import Payload


@piece
def push_share(payload: Payload, site: Site) -> float:
    """Return by how much the film's resistance to rolling F_R pushes a roller along the raceway, 2 R cos(alpha)/r_R - 1 [-].

    R is the reduced radius along the line of contact, r_R that of the roller in the plane.
    """
    share: float = 2.0 * site.reduced_radius * payload.spin_share / payload.roller_radius - 1.0
    return share


@piece
def prepare_bound(payload: Payload, work: Workspace, count: int) -> None:
    """Write the equations of rollers between both raceways and a bar, as far as they do not depend on the bodies' velocities."""
    bound, h = work.bound[0], payload.step
    inner, outer, bar = bound.inner, bound.outer, bound.bar
    oil, inner_share, outer_share = payload.lubrication, push_share(payload, payload.inner), push_share(payload, payload.outer)
    mass, inertia = 2.0 * payload.roller_mass, 2.0 * payload.roller_inertia / (payload.roller_radius * payload.roller_radius)
    for k in range(count):
        inx, iny = inner.normal_x[k], inner.normal_y[k]
        itx, ity = -inner.radial_y[k], inner.radial_x[k]
        ig, il = inner.force_slope[k], inner.friction_slope[k]
        ip, ic = inner.force_offset[k], inner.friction_offset[k]
        onx, ony = outer.normal_x[k], outer.normal_y[k]
        otx, oty = -outer.radial_y[k], outer.radial_x[k]
        og, ol = outer.force_slope[k], outer.friction_slope[k]
        op, oc = outer.force_offset[k], outer.friction_offset[k]
        bnx, bny, side = bound.tangent_x[k], bound.tangent_y[k], bar.side[k]
        btx, bty = bny, -bnx
        bg, bl = bar.force_slope[k], bar.friction_slope[k]
        bp, bc = side * bar.force_offset[k], bar.friction_offset[k]
        inner_drag, outer_drag = load_resistance(oil, inner.film, k, 1.0), load_resistance(oil, outer.film, k, 1.0)
        idrag = ic + load_resistance(oil, inner.film, k, inner_share)
        odrag = oc + load_resistance(oil, outer.film, k, outer_share)

        bound.rhs_x[k] = mass * bound.contact_free_vx[k] + h * (ip * inx - idrag * itx - op * onx - odrag * otx - bp * bnx - bc * btx)
        bound.rhs_y[k] = mass * bound.contact_free_vy[k] + h * (ip * iny - idrag * ity - op * ony - odrag * oty - bp * bny - bc * bty)
        bound.rhs_rim[k] = inertia * bound.contact_free_rim[k] + h * (ic - oc + side * bc - inner_drag + outer_drag)
        xx = mass + h * (ig * inx * inx + il * itx * itx + og * onx * onx + ol * otx * otx + bg * bnx * bnx + bl * btx * btx)
        xy = h * (ig * inx * iny + il * itx * ity + og * onx * ony + ol * otx * oty + bg * bnx * bny + bl * btx * bty)
        yy = mass + h * (ig * iny * iny + il * ity * ity + og * ony * ony + ol * oty * oty + bg * bny * bny + bl * bty * bty)
        xw, yw = h * (ol * otx - il * itx - side * bl * btx), h * (ol * oty - il * ity - side * bl * bty)
        by_w = 1.0 / (inertia + h * (il + ol + bl))
        xx, xy, yy = xx - by_w * xw * xw, xy - by_w * xw * yw, yy - by_w * yw * yw
        by_determinant = 1.0 / (xx * yy - xy * xy)
        bound.inverse_xx[k], bound.inverse_yy[k] = yy * by_determinant, xx * by_determinant
        bound.inverse_xy[k], bound.inverse_rim[k] = -xy * by_determinant, by_w
        bound.coupling_x[k], bound.coupling_y[k] = by_w * xw, by_w * yw


@piece
def solve_bound(payload: Payload, work: Workspace, count: int, surface: float) -> None:
    """Solve for rollers between both raceways and a bar, at the present mean velocities of rings and cages.

    A pinned roller moves with its cage and turns by itself. ``surface`` is the speed of the inner ring's surface [m/s].
    """
    bound, mean, h, pitch = work.bound[0], work.mean_velocity, payload.step, payload.pitch_radius
    inner, outer, bar = bound.inner, bound.outer, bound.bar
    oil, inner_share, outer_share = payload.lubrication, push_share(payload, payload.inner), push_share(payload, payload.outer)
    inner_x, inner_y, outer_x, outer_y = mean[INNER, 0], mean[INNER, 1], mean[OUTER, 0], mean[OUTER, 1]
    cages = of_cages(mean)
    for k in range(count):
        cage_vx, cage_vy, turn = of_row(cages, bound.second_row[k])
        # Per contact: normal n, tangent t, and the velocity of the body there along both.
        inx, iny = inner.normal_x[k], inner.normal_y[k]
        itx, ity = -inner.radial_y[k], inner.radial_x[k]
        ig, il = inner.force_slope[k], inner.friction_slope[k]
        ipn, ipt = inner_x * inx + inner_y * iny + inner.surface_speed_normal[k], inner_x * itx + inner_y * ity + surface
        onx, ony = outer.normal_x[k], outer.normal_y[k]
        otx, oty = -outer.radial_y[k], outer.radial_x[k]
        og, ol = outer.force_slope[k], outer.friction_slope[k]
        opn, opt = outer_x * onx + outer_y * ony, outer_x * otx + outer_y * oty
        bnx, bny, side = bound.tangent_x[k], bound.tangent_y[k], bar.side[k]
        btx, bty = bny, -bnx
        bg, bl = bar.force_slope[k], bar.friction_slope[k]
        lever_x, lever_y = bar.lever_x[k], bar.lever_y[k]
        bar_vx, bar_vy = cage_vx - turn * lever_y, cage_vy + turn * lever_x
        bpn, bpt = bar_vx * bnx + bar_vy * bny, bar_vx * btx + bar_vy * bty

        i_push, i_drag, o_push, o_drag, b_push, b_drag = ig * ipn, il * ipt, og * opn, ol * opt, bg * bpn, bl * bpt
        w = bound.rhs_rim[k] + h * (o_drag - i_drag - side * b_drag)
        coupling_x, coupling_y = bound.coupling_x[k], bound.coupling_y[k]
        x = i_push * inx + i_drag * itx + o_push * onx + o_drag * otx + b_push * bnx + b_drag * btx
        y = i_push * iny + i_drag * ity + o_push * ony + o_drag * oty + b_push * bny + b_drag * bty
        x, y = bound.rhs_x[k] + h * x - coupling_x * w, bound.rhs_y[k] + h * y - coupling_y * w
        free_x = bound.inverse_xx[k] * x + bound.inverse_xy[k] * y
        free_y = bound.inverse_xy[k] * x + bound.inverse_yy[k] * y
        free = bound.free[k] > 0.0
        mean_x = free_x if free else cage_vx + pitch * turn * bnx
        mean_y = free_y if free else cage_vy + pitch * turn * bny
        rim = bound.inverse_rim[k] * w - coupling_x * mean_x - coupling_y * mean_y
        bound.mean_vx[k], bound.mean_vy[k], bound.mean_rim[k] = mean_x, mean_y, rim

        i_normal = inner.force_offset[k] + i_push - ig * (mean_x * inx + mean_y * iny)
        i_friction = inner.friction_offset[k] - i_drag + il * (mean_x * itx + mean_y * ity - rim)
        o_normal = outer.force_offset[k] - o_push + og * (mean_x * onx + mean_y * ony)
        o_friction = outer.friction_offset[k] - o_drag + ol * (mean_x * otx + mean_y * oty + rim)
        b_normal = b_push - side * bar.force_offset[k] - bg * (mean_x * bnx + mean_y * bny)
        b_friction = bar.friction_offset[k] - b_drag + bl * (mean_x * btx + mean_y * bty - side * rim)
        i_friction += load_resistance(oil, inner.film, k, inner_share)
        o_friction += load_resistance(oil, outer.film, k, outer_share)
        fix, fiy = i_normal * inx - i_friction * itx, i_normal * iny - i_friction * ity
        fox, foy = -o_normal * onx - o_friction * otx, -o_normal * ony - o_friction * oty
        fbx, fby = b_normal * bnx - b_friction * btx, b_normal * bny - b_friction * bty
        carried_x, carried_y = 0.0 if free else fix + fox, 0.0 if free else fiy + foy
        bound.force_on_inner_x[k], bound.force_on_inner_y[k] = -fix, -fiy
        bound.force_on_outer_x[k], bound.force_on_outer_y[k] = -fox, -foy
        bound.force_on_cage_x[k], bound.force_on_cage_y[k] = carried_x - fbx, carried_y - fby
        bound.torque_on_cage[k] = pitch * (carried_x * bnx + carried_y * bny) - lever_x * fby + lever_y * fbx


@piece
def sum_bound_forces(payload: Payload, work: Workspace) -> None:
    """Write the forces of bound rollers on rings and cages, row by row so that rows that are alike stay alike."""
    bound, forces, k = work.bound[0], work.force_of_bound, 0
    for body in range(forces.shape[0]):
        forces[body, 0] = forces[body, 1] = forces[body, 2] = 0.0
    for row in range(payload.free.shape[0]):
        ix, iy, ox, oy, cx, cy, turn = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        while k < work.row_ends[row]:
            ix += bound.force_on_inner_x[k]
            iy += bound.force_on_inner_y[k]
            ox += bound.force_on_outer_x[k]
            oy += bound.force_on_outer_y[k]
            cx += bound.force_on_cage_x[k]
            cy += bound.force_on_cage_y[k]
            turn += bound.torque_on_cage[k]
            k += 1
        forces[INNER, 0] += ix
        forces[INNER, 1] += iy
        forces[OUTER, 0] += ox
        forces[OUTER, 1] += oy
        forces[CAGE + row, 0], forces[CAGE + row, 1], forces[CAGE + row, 2] = cx, cy, turn
