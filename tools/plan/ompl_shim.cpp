#include "tools/plan/ompl_shim.h"

#include <cmath>
#include <cstdlib>
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
    explicit Search(const ompl_search &asked)
        : asked_(asked), space_(std::make_shared<ob::RealVectorStateSpace>(asked.count)),
          information_(std::make_shared<ob::SpaceInformation>(space_)), given_(asked.count)
    {
        space_->setBounds(0, 1);
        information_->setStateValidityChecker([this](const ob::State *s) { return is_free(s); });
        information_->setStateValidityCheckingResolution(asked.step / std::sqrt(asked.count));
        information_->setup();
    }

    bool find(std::vector<double> &way)
    {
        auto problem = std::make_shared<ob::ProblemDefinition>(information_);
        ob::ScopedState<> start(space_);
        put(asked_.start, start.get());
        problem->addStartState(start);
        auto goal = std::make_shared<ob::GoalStates>(information_);
        for (size_t i = 0; i < asked_.goals; i++) {
            ob::ScopedState<> one(space_);
            put(asked_.goal + i * asked_.count, one.get());
            goal->addState(one);
        }
        problem->setGoal(goal);
        auto planner = make();
        planner->setProblemDefinition(problem);
        planner->setup();
        const auto status = planner->solve(ending(asked_.states));
        planner->clear(); /* LazyPRM does not when it ends */
        if (status != ob::PlannerStatus::EXACT_SOLUTION) {
            return false;
        }
        auto path = std::static_pointer_cast<og::PathGeometric>(problem->getSolutionPath());
        smooth(*path);
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

  private:
    void put(const double *from, ob::State *to) const
    {
        for (int k = 0; k < asked_.count; k++) {
            to->as<ob::RealVectorStateSpace::StateType>()->values[k] =
                (from[k] - asked_.low[k]) / (asked_.high[k] - asked_.low[k]);
        }
    }

    void take(const ob::State *from)
    {
        for (int k = 0; k < asked_.count; k++) {
            const double part = from->as<ob::RealVectorStateSpace::StateType>()->values[k];
            given_[k] = asked_.low[k] + part * (asked_.high[k] - asked_.low[k]);
        }
    }

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

    /* Shorter while that is free; each of these ends by itself. */
    void smooth(og::PathGeometric &path)
    {
        og::PathSimplifier simplifier(information_);
        for (int k = 0; k < 3; k++) {
            simplifier.reduceVertices(path);
            simplifier.shortcutPath(path, 100, 20, 0.33, 0.005);
        }
        simplifier.collapseCloseVertices(path);
    }

    const ompl_search &asked_;
    std::shared_ptr<ob::RealVectorStateSpace> space_;
    std::shared_ptr<ob::SpaceInformation> information_;
    std::vector<double> given_;
    size_t looked_ = 0;
};

} // namespace

bool ompl_is_built(void)
{
    return true;
}

ad_status ompl_find(const ompl_search *search, double **way, size_t *length, size_t *looked,
                    ad_error *error)
{
    *way = nullptr;
    *length = *looked = 0;
    try {
        ompl::msg::noOutputHandler();
        ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(search->seed % 4294967295) + 1);
        Search of(*search);
        std::vector<double> found;
        const bool any = of.find(found);
        *looked = of.looked();
        if (any) {
            *way = static_cast<double *>(std::malloc(found.size() * sizeof(double)));
            if (!*way) {
                return ad_fail(error, AD_NO_MEMORY, "out of memory for a way");
            }
            std::copy(found.begin(), found.end(), *way);
            *length = found.size() / static_cast<size_t>(search->count);
        }
        return AD_OK;
    } catch (const std::bad_alloc &) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a search");
    } catch (const std::exception &what) {
        return ad_fail(error, AD_BAD_ARGUMENT, "OMPL: %.400s", what.what());
    }
}
