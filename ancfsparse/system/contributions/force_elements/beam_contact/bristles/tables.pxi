"""Bristles and the forces of friction as arrays; an include file."""


cdef bint set_bristles_at(Data *self, const double *q) noexcept nogil:
    """Set the touching points and the bristles of a state; return whether that succeeds."""
    return find_end(self, q, NULL) and set_bristles(self, False)


cdef bristle_table(Data *data, const double *q):
    """Return the arrays of `BeamContact.bristles`."""
    cdef const Bristle *each
    cdef double[9] block
    cdef double[4] of_nodes
    cdef double size
    cdef ptrdiff_t k, i = 0, dim = data.dim
    cdef int c, e
    n = 0
    if (data.is_static or data.is_sticking) and set_bristles_at(data, q):
        n = data.n_bristles
    elements, weights = np.zeros((n, 2), np.int32), np.zeros((n, 2, 4))
    blocks, sliding = np.zeros((n, dim, dim)), np.zeros((n, dim))
    cdef int32_t[:, ::1] e_view = elements
    cdef double[:, ::1] s_view = sliding
    cdef double[:, :, ::1] w_view = weights, b_view = blocks
    for k in range(n):
        each = data.bristle + k
        if each.limit == 0.0:
            continue
        bristle_block(data, each, block)
        e_view[i, 0], e_view[i, 1] = each.a, each.b
        size = sqrt(dot(each.trial, each.trial))
        for c in range(dim if data.is_static and size > each.limit else 0):
            s_view[i, c] = -each.mu * each.trial[c] / size
        for c in range(dim):
            for e in range(dim):
                b_view[i, c, e] = block[3 * c + e]
        weigh_nodes(data, each.a, each.of_a, of_nodes)
        for c in range(4):
            w_view[i, 0, c] = of_nodes[c]
        weigh_nodes(data, each.b, each.of_b, of_nodes)
        for c in range(4):
            w_view[i, 1, c] = of_nodes[c]
        i += 1
    return elements[:i], weights[:i], blocks[:i], sliding[:i]


cdef set_bristle_forces(Data *data, const double[::1] history, double[:, ::1] out):
    """Set the friction of bristles on the points of `touches`."""
    cdef const Touch *touch
    cdef const Bristle *each
    cdef ptrdiff_t k, c
    cdef double share, interval = data.interval
    cdef double *slots = data.slots
    cdef double[::1] own = np.array(history)
    data.slots, data.interval = &own[0], 0.0
    if not (recall(data) and add_to_bristles(data, &data.at_now, 1.0)
            and stretch_all(data, data.now, data.now, False)):
        raise ValueError("the bristles of a state do not fit in its history")
    data.slots, data.interval = slots, interval
    for k in range(data.at_now.n):
        touch = data.at_now.touch + k
        each = data.bristle + find_bristle(data, min(touch.a, touch.b), max(touch.a, touch.b))
        share = pressure(touch) / each.pressure
        for c in range(data.dim):
            out[k, c] = share * each.f[c] if touch.a < touch.b else -share * each.f[c]


cdef set_sliding_forces(Data *data, double[:, ::1] out):
    """Set the friction with a slip speed on the points of `touches`, from the speeds in `data`."""
    cdef const Touch *touch
    cdef double[3] u
    cdef double size
    cdef ptrdiff_t k, c
    for k in range(data.at_now.n):
        touch = data.at_now.touch + k
        size = data.friction * pressure(touch) / slide(data, touch, u)
        for c in range(data.dim):
            out[k, c] = -size * u[c]
