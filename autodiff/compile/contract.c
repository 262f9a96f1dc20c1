/* One instruction for several operations of a pass, where what lies between has no other use: a
 * product and its sum, a sum and its tanh. */
#include "autodiff/compile/program.h"

/* Is this a product that nobody else needs, of as many rows as its user n? */
static bool is_own_product(const pass_plan *plan, int product, const node *n)
{
    const node *m = &plan->nodes[product];
    return (m->op == OP_MUL || m->op == OP_SCALED_MUL) && plan->uses[product] == 1 &&
           m->rows == n->rows;
}

static void take_arguments(pass_plan *plan, int id, int product)
{
    plan->arguments[id][0] = plan->arguments[product][0];
    plan->arguments[id][1] = plan->arguments[product][1];
    plan->nodes[product].op = OP_COUNT;
}

/* A constant times a product. */
static void contract_scaled(pass_plan *plan, int id)
{
    node *n = &plan->nodes[id];
    const node *factor = &plan->tape->nodes[plan->arguments[id][0]];
    int product = plan->arguments[id][1];
    if (factor->op == OP_CONSTANT && factor->splat && plan->nodes[product].op == OP_MUL &&
        is_own_product(plan, product, n)) {
        n->op = OP_SCALED_MUL;
        n->number = factor->number;
        take_arguments(plan, id, product);
    }
}

static double factor_of(const node *product)
{
    return product->op == OP_SCALED_MUL ? product->number : 1;
}

/* k a b + c d or k a b - c d from two products, of which one may have a constant factor. */
static bool contract_pair(pass_plan *plan, int id)
{
    node *n = &plan->nodes[id];
    int one = plan->arguments[id][0], other = plan->arguments[id][1];
    if (!is_own_product(plan, one, n) || !is_own_product(plan, other, n)) {
        return false;
    }
    double sign = n->op == OP_SUB ? -1 : 1, factor = factor_of(&plan->nodes[one]);
    bool swap = factor_of(&plan->nodes[other]) != 1;
    if (swap && factor != 1) {
        return false;
    }
    n->op = swap || sign > 0 ? OP_PAIR_ADD : OP_PAIR_SUB;
    n->number = swap ? sign * factor_of(&plan->nodes[other]) : factor;
    n->whole = swap && sign < 0;
    n->count = 4;
    take_arguments(plan, id, swap ? other : one);
    plan->arguments[id][2] = plan->arguments[swap ? one : other][0];
    plan->arguments[id][3] = plan->arguments[swap ? one : other][1];
    plan->nodes[swap ? one : other].op = OP_COUNT;
    return true;
}

/* a b + c, a b - c, c - a b, where a b may have a constant factor. */
static void contract_sum(pass_plan *plan, int id)
{
    node *n = &plan->nodes[id];
    for (int i = 0; i < 2; i++) {
        int product = plan->arguments[id][i], other = plan->arguments[id][1 - i];
        if (!is_own_product(plan, product, n)) {
            continue;
        }
        bool scaled = plan->nodes[product].op == OP_SCALED_MUL, minus = n->op == OP_SUB;
        if (scaled) {
            bool first = minus && i == 0;
            n->whole = minus && i == 1;
            n->number =
                minus && i == 1 ? -plan->nodes[product].number : plan->nodes[product].number;
            n->op = first ? OP_SCALED_MUL_SUB : OP_SCALED_MUL_ADD;
        } else {
            n->op = !minus ? OP_MUL_ADD : i == 0 ? OP_MUL_SUB : OP_SUB_MUL;
        }
        n->count = 3;
        take_arguments(plan, id, product);
        plan->arguments[id][2] = other;
        return;
    }
}

/* The activation of a layer, with its bias. */
static void contract_tanh(pass_plan *plan, int id)
{
    node *n = &plan->nodes[id];
    int sum = plan->arguments[id][0];
    if (plan->nodes[sum].op == OP_ADD && plan->uses[sum] == 1 && plan->nodes[sum].rows == n->rows) {
        n->op = OP_TANH_SUM;
        n->count = 2;
        take_arguments(plan, id, sum);
    }
}

void ad_plan_contract(pass_plan *plan)
{
    for (int id = 0; id < plan->count; id++) {
        int op = plan->nodes[id].op;
        if (op == OP_MUL) {
            contract_scaled(plan, id);
        } else if ((op == OP_ADD || op == OP_SUB) && !contract_pair(plan, id)) {
            contract_sum(plan, id);
        } else if (op == OP_TANH) {
            contract_tanh(plan, id);
        }
    }
}
