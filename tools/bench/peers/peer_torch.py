"""The step in PyTorch. See peer.serve for the arguments."""
import peer
import rod


def prepare(case, method, threads):
    import torch

    torch.set_num_threads(threads)
    torch.set_default_dtype(torch.float64)
    numbers, n = case.numbers, len(case.s)
    x = torch.tensor(case.x)
    s, t = torch.tensor(case.s), torch.tensor(case.t)
    blend = torch.stack([torch.tensor(f) for f in case.blend()])
    rates = 2.0, 2.0 / numbers["duration"]

    def coefficients(layers, s, t):
        """The network's outputs [5][points][7], carried through the layers as one block."""
        weights, bias = layers[0]
        z_s, z_t = weights[:, 0] * rates[0], weights[:, 1] * rates[1]
        z = s[:, None] * z_s + t[:, None] * z_t + (bias - weights[:, 0] - weights[:, 1])
        y = torch.tanh(z)
        g, h = 1 - y * y, -2 * y
        y_s, y_t = g * z_s, g * z_t
        block = torch.stack([y, y_s, h * y_s * z_s, y_t, h * y_t * z_t])
        for weights, bias in layers[1:-1]:
            z, z_s, z_ss, z_t, z_tt = (block @ weights.T).unbind(0)
            y = torch.tanh(z + bias)
            g, h = 1 - y * y, -2 * y
            y_s, y_t = g * z_s, g * z_t
            block = torch.stack([y, y_s, g * z_ss + h * y_s * z_s, y_t, g * z_tt + h * y_t * z_t])
        weights, bias = layers[-1]
        out = block @ weights.T
        return torch.cat([out[:1] + bias, out[1:]])

    def network(layers, s, t):
        y = torch.stack([rates[0] * s - 1, rates[1] * t - 1], dim=1)
        for weights, bias in layers[:-1]:
            y = torch.tanh(torch.nn.functional.linear(y, weights, bias))
        return torch.nn.functional.linear(y, *layers[-1])

    def residuals(y, blend, world=False):
        # contiguous rows over the points: the residual is elementwise
        return rod.residual_of_outputs(numbers, blend, y.permute(2, 0, 1).contiguous(), world)

    def leaves():
        """A leaf per layer, as a module has; the gradient in the order of the flat vector."""
        layers = [(w.clone().requires_grad_(), b.clone().requires_grad_())
                  for w, b in case.layers(x)]
        return layers, [a for layer in layers for a in layer]

    def flat(gradients):
        return torch.cat([g.reshape(-1) for g in gradients])

    def split(chunk):
        """Chunks that stay in the cache; their gradients add up."""
        size = chunk or n
        return list(zip(s.split(size), t.split(size), blend.split(size, dim=1)))

    def run_coefficients(chunk):
        layers, flat_leaves = leaves()
        parts = split(chunk)

        def step():
            loss = 0.0
            for leaf in flat_leaves:
                leaf.grad = None
            for ps, pt, pf in parts:
                r = torch.stack(residuals(coefficients(layers, ps, pt), pf))
                part = (r * r).sum() / n
                part.backward()
                loss += part.detach()
            return loss, flat([leaf.grad for leaf in flat_leaves])

        return step

    def run_nested(chunk):
        """As most public networks of this kind do: every derivative is another backward pass that
        is itself recorded. One pass by s and t together where both are wanted."""
        layers, flat_leaves = leaves()
        parts = split(chunk)

        def derivative(y, *inputs):
            return torch.autograd.grad(y, inputs, torch.ones_like(y), create_graph=True)

        def outputs(a, b):
            out = network(layers, a, b)
            y = []
            for o in range(7):
                value = out[:, o]
                y_s, y_t = derivative(value, a, b)
                y.append((value, y_s, derivative(y_s, a)[0], y_t, derivative(y_t, b)[0]))
            return y

        def step():
            loss = 0.0
            for leaf in flat_leaves:
                leaf.grad = None
            for ps, pt, pf in parts:
                y = outputs(ps.clone().requires_grad_(), pt.clone().requires_grad_())
                r = rod.residual_of_outputs(numbers, pf, y)
                part = sum((q * q).sum() for q in r) / n
                part.backward(inputs=flat_leaves)
                loss += part.detach()
            return loss, flat([leaf.grad for leaf in flat_leaves])

        return step

    def solve(jacobian, r):
        jtj, jtr = jacobian.T @ jacobian, jacobian.T @ r
        damped = jtj + 1e-3 * torch.diag(torch.diag(jtj) + 1e-3)
        factor = torch.linalg.cholesky(damped)
        return r @ r, jtj, jtr, torch.cholesky_solve(-jtr[:, None], factor)

    def run_jacrev():
        chunk = 128

        def rows(x, s, t, blend):
            y = coefficients(case.layers(x), s[None], t[None])
            r = torch.cat(residuals(y, blend[:, None], world=True)) / n ** 0.5
            return r, r

        from torch import func  # since PyTorch 2

        per_point = func.vmap(func.jacrev(rows, has_aux=True), (None, 0, 0, 1))

        def step():
            parts = [per_point(x, *p)
                     for p in zip(s.split(chunk), t.split(chunk), blend.split(chunk, dim=1))]
            jacobian = torch.cat([p[0].reshape(-1, len(x)) for p in parts])
            return solve(jacobian, torch.cat([p[1].reshape(-1) for p in parts]))

        return step

    def run_rows():
        """Points are independent: the adjoint of row i of all points at once, at every layer, times
        the layer's input is the Jacobian's block. Six backward passes to the layers' sums."""
        def step():
            layers = case.layers(x)
            taps = [torch.zeros(5, n, w.shape[0], requires_grad=True) for w, _ in layers]
            inputs, ones = [], torch.ones(n)
            none = torch.zeros(n)
            first = torch.stack([torch.stack([rates[0] * s - 1, rates[1] * t - 1], dim=1),
                                 torch.stack([ones * rates[0], none], dim=1),
                                 torch.zeros(n, 2),
                                 torch.stack([none, ones * rates[1]], dim=1),
                                 torch.zeros(n, 2)])
            block = first
            for i, (weights, bias) in enumerate(layers):
                inputs.append(block.detach())
                z = block @ weights.T + taps[i]
                z0 = z[0] + bias
                if i == len(layers) - 1:
                    block = torch.cat([z0[None], z[1:]])
                    break
                y = torch.tanh(z0)
                g, h = 1 - y * y, -2 * y
                y_s, y_t = g * z[1], g * z[3]
                block = torch.stack([y, y_s, g * z[2] + h * y_s * z[1],
                                     y_t, g * z[4] + h * y_t * z[3]])
            r = residuals(block, blend, world=True)
            jacobian = torch.empty(6 * n, len(x))
            for row in range(6):
                adjoints = torch.autograd.grad(r[row].sum(), taps, retain_graph=row < 5)
                at, target = 0, jacobian[row * n:(row + 1) * n]
                for adjoint, fed in zip(adjoints, inputs):
                    m, k = adjoint.shape[2], fed.shape[2]
                    product = torch.bmm(adjoint.permute(1, 2, 0), fed.permute(1, 0, 2))
                    target[:, at:at + m * k] = product.reshape(n, m * k)
                    target[:, at + m * k:at + m * k + m] = adjoint[0]
                    at += m * k + m
            jacobian /= n ** 0.5
            return solve(jacobian, torch.cat(r).detach() / n ** 0.5)

        return step

    if method.startswith("gn-"):
        step = run_jacrev() if method == "gn-jacrev" else run_rows()
        return step, lambda r: case.difference_normal(*r[:3])
    name, _, chunk = method.partition("/")
    run = run_nested if name == "nested" else run_coefficients
    step = run(int(chunk or 0))
    return step, lambda result: case.difference(*result)


if __name__ == "__main__":
    peer.serve(prepare)
