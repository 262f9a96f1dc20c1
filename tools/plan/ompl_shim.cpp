#include "tools/plan/ompl_shim.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <new>
#include <vector>

#include <ompl/base/SpaceInformation.h>
#include <ompl/base/goals/GoalStates.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/PathSimplifier.h>
#include <ompl/geometric/planners/prm/LazyPRM.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

namespace ob = ompl::base;
namespace og = ompl::geometric;

namespace
{

/* OMPL's variables go from 0 to 1 over each range. */
class Search
{
  public:
    Search(const Search &) = delete; /* its planners point to it */
    Search &operator=(const Search &) = delete;
    explicit Search(const ompl_search &asked)
        : asked_(asked), space_(std::make_shared<ob::RealVectorStateSpace>(asked.count)),
          information_(std::make_shared<ob::SpaceInformation>(space_)), given_(asked.count)
    {
        space_->setBounds(0, 1);
        information_->setStateValidityChecker([this](const ob::State *s) { return is_free(s); });
        ask(asked);
    }

    /* Something else of the same variables. */
    void ask(const ompl_search &asked)
    {
        asked_ = asked;
        looked_ = 0;
        ompl::msg::noOutputHandler();
        ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(asked.seed % 4294967295) + 1);
        information_->setStateValidityCheckingResolution(asked.step / std::sqrt(asked.count));
        information_->setup();
    }

    const ob::SpaceInformationPtr &information() const
    {
        return information_;
    }

    bool find(ob::Planner &planner, int shortcuts, std::vector<double> &way)
    {
        auto problem = std::make_shared<ob::ProblemDefinition>(information_);
        ob::ScopedState<> start(space_);
        put(asked_.start, start.get());
        problem->addStartState(start);
        auto goal = std::make_shared<ob::GoalStates>(information_);
        bool any = false;
        for (size_t i = 0; i < asked_.goals; i++) {
            ob::ScopedState<> one(space_);
            put(asked_.goal + i * asked_.count, one.get());
            any = information_->isValid(one.get()) || any;
            goal->addState(one);
        }
        if (!any || !information_->isValid(start.get())) {
            return false; /* planners wait for a goal that is free */
        }
        problem->setGoal(goal);
        planner.setProblemDefinition(problem);
        if (!planner.isSetup()) {
            planner.setup();
        }
        if (!solve(planner)) {
            return false;
        }
        auto path = std::static_pointer_cast<og::PathGeometric>(problem->getSolutionPath());
        smooth(*path, shortcuts);
        for (const ob::State *s : path->getStates()) {
            take(s);
            way.insert(way.end(), given_.begin(), given_.end());
        }
        return true;
    }

    size_t looked() const
    {
        return looked_;
    }

    /* From what is asked to OMPL's, and back. */
    void put(const double *from, ob::State *to) const
    {
        for (int k = 0; k < asked_.count; k++) {
            to->as<ob::RealVectorStateSpace::StateType>()->values[k] =
                (from[k] - asked_.low[k]) / (asked_.high[k] - asked_.low[k]);
        }
    }

    const std::vector<double> &take(const ob::State *from)
    {
        for (int k = 0; k < asked_.count; k++) {
            const double part = from->as<ob::RealVectorStateSpace::StateType>()->values[k];
            given_[k] = asked_.low[k] + part * (asked_.high[k] - asked_.low[k]);
        }
        return given_;
    }

    ob::PlannerPtr make() const
    {
        switch (asked_.method) {
        case PLAN_RRT_STAR:
            return std::make_shared<og::RRTstar>(information_);
        case PLAN_PRM: /* edges are looked at when they are used; without threads, so the same again
                        */
            return std::make_shared<og::LazyPRM>(information_);
        default:
            return std::make_shared<og::RRTConnect>(information_);
        }
    }

  private:
    bool is_free(const ob::State *s)
    {
        looked_++;
        if (!space_->satisfiesBounds(s)) {
            return false;
        }
        take(s);
        return asked_.is_free(asked_.context, given_.data());
    }

    ob::PlannerTerminationCondition ending(size_t states)
    {
        const size_t last = looked_ + states;
        return ob::PlannerTerminationCondition([this, last] { return looked_ >= last; });
    }

    /* LazyPRM takes one more of the goals each time; others take all of them. */
    bool solve(ob::Planner &planner)
    {
        const size_t times = dynamic_cast<og::LazyPRM *>(&planner) ? asked_.goals : 1;
        for (size_t left = times; left > 0; left--) {
            const size_t states = (asked_.states - std::min(looked_, asked_.states)) / left;
            if (planner.solve(ending(states)) == ob::PlannerStatus::EXACT_SOLUTION) {
                return true;
            }
        }
        return false;
    }

    /* Without corners that are not needed; then shorter while that is free. Each of these ends by
     * itself. Shortcuts make a way of a roadmap a fourth shorter, and twenty times later. */
    void smooth(og::PathGeometric &path, int shortcuts)
    {
        og::PathSimplifier simplifier(information_);
        simplifier.reduceVertices(path);
        for (int k = 0; k < shortcuts; k++) {
            simplifier.shortcutPath(path, 100, 10, 0.33, 0.005);
            simplifier.reduceVertices(path);
        }
        simplifier.collapseCloseVertices(path);
    }

    ompl_search asked_;
    std::shared_ptr<ob::RealVectorStateSpace> space_;
    std::shared_ptr<ob::SpaceInformation> information_;
    std::vector<double> given_;
    size_t looked_ = 0;
};

/* LazyPRM that is kept from search to search, and in arrays. */
class Roadmap : public og::LazyPRM
{
  public:
    explicit Roadmap(Search &of) : og::LazyPRM(of.information()), of_(of)
    {
        setProblemDefinition(std::make_shared<ob::ProblemDefinition>(si_)); /* a length of ways */
        setup();
    }

    ~Roadmap() override
    {
        og::LazyPRM::clear();
    }

    /* Nodes that are free, and edges to their neighbours. */
    void grow(size_t nodes)
    {
        ob::State *const s = si_->allocState();
        for (size_t tries = 1000 * nodes; tries > 0 && milestoneCount() < nodes; tries--) {
            sampler_->sampleUniform(s);
            if (si_->isValid(s)) {
                addMilestone(si_->cloneState(s));
            }
        }
        si_->freeState(s);
    }

    void load(const ompl_roadmap &from, size_t count, bool known)
    {
        const unsigned validity = known ? VALIDITY_TRUE : VALIDITY_UNKNOWN;
        std::vector<Vertex> at;
        for (size_t i = 0; i < from.nodes; i++) {
            const Vertex v = boost::add_vertex(g_);
            stateProperty_[v] = si_->allocState();
            of_.put(from.node + i * count, stateProperty_[v]);
            vertexValidityProperty_[v] = validity;
            vertexComponentProperty_[v] = componentCount_;
            componentSize_[componentCount_++] = 1;
            nn_->add(v);
            at.push_back(v);
        }
        for (size_t i = 0; i < from.edges; i++) {
            const Vertex a = at.at(from.edge[2 * i]), b = at.at(from.edge[2 * i + 1]);
            const ob::Cost length = opt_->motionCost(stateProperty_[a], stateProperty_[b]);
            const auto e = boost::add_edge(a, b, Graph::edge_property_type(length), g_).first;
            edgeValidityProperty_[e] = validity;
            uniteComponents(a, b);
        }
    }

    /* Edges that are free. */
    void save(std::vector<double> &node, std::vector<uint64_t> &edge)
    {
        std::map<Vertex, uint64_t> number;
        for (auto all = boost::vertices(g_); all.first != all.second; ++all.first) {
            const std::vector<double> &q = of_.take(stateProperty_[*all.first]);
            number.emplace(*all.first, number.size());
            node.insert(node.end(), q.begin(), q.end());
        }
        for (auto all = boost::edges(g_); all.first != all.second; ++all.first) {
            const Vertex a = boost::source(*all.first, g_), b = boost::target(*all.first, g_);
            if (si_->checkMotion(stateProperty_[a], stateProperty_[b])) {
                edge.push_back(number.at(a));
                edge.push_back(number.at(b));
            }
        }
    }

  private:
    Search &of_;
};

/* In memory of C; NULL where there is none. */
template <typename T> T *copy(const std::vector<T> &from)
{
    T *const to = static_cast<T *>(std::malloc((from.size() + 1) * sizeof(T)));
    if (!to) {
        throw std::bad_alloc();
    }
    std::copy(from.begin(), from.end(), to);
    return to;
}

template <typename F> ad_status guarded(ad_error *error, F work)
{
    try {
        work();
        return AD_OK;
    } catch (const std::bad_alloc &) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a search");
    } catch (const std::exception &what) {
        return ad_fail(error, AD_BAD_ARGUMENT, "OMPL: %.400s", what.what());
    }
}

void find(Search &of, ob::Planner &planner, int shortcuts, int count, double **way, size_t *length,
          size_t *looked)
{
    std::vector<double> found;
    const bool any = of.find(planner, shortcuts, found);
    *looked = of.looked();
    if (any) {
        *way = copy(found);
        *length = found.size() / static_cast<size_t>(count);
    }
}

} // namespace

struct ompl_map {
    explicit ompl_map(const ompl_search &asked) : search(asked), roadmap(search)
    {
    }

    Search search;
    Roadmap roadmap;
};

bool ompl_is_built(void)
{
    return true;
}

ad_status ompl_find(const ompl_search *search, double **way, size_t *length, size_t *looked,
                    ad_error *error)
{
    *way = nullptr;
    *length = *looked = 0;
    return guarded(error, [&] {
        Search of(*search);
        const ob::PlannerPtr planner = of.make();
        find(of, *planner, 1, search->count, way, length, looked);
        planner->clear(); /* LazyPRM does not when it ends */
    });
}

ad_status ompl_roadmap_make(const ompl_search *search, size_t nodes, ompl_roadmap *result,
                            ad_error *error)
{
    *result = ompl_roadmap{};
    return guarded(error, [&] {
        std::vector<double> node;
        std::vector<uint64_t> edge;
        ompl_map map(*search);
        map.roadmap.grow(nodes);
        map.roadmap.save(node, edge);
        result->node = copy(node);
        result->edge = copy(edge);
        result->nodes = node.size() / static_cast<size_t>(search->count);
        result->edges = edge.size() / 2;
    });
}

ad_status ompl_map_create(const ompl_search *search, const ompl_roadmap *of, bool known,
                          ompl_map **result, ad_error *error)
{
    *result = nullptr;
    return guarded(error, [&] {
        auto map = std::make_unique<ompl_map>(*search);
        map->roadmap.load(*of, static_cast<size_t>(search->count), known);
        *result = map.release();
    });
}

ad_status ompl_map_find(ompl_map *map, const ompl_search *search, bool forget, double **way,
                        size_t *length, size_t *looked, ad_error *error)
{
    *way = nullptr;
    *length = *looked = 0;
    return guarded(error, [&] {
        map->search.ask(*search);
        if (forget) {
            map->roadmap.clearValidity();
        }
        find(map->search, map->roadmap, 0, search->count, way, length, looked);
    });
}

void ompl_map_free(ompl_map *map)
{
    delete map;
}
