/** Computations under way. */
#ifndef MOULAGE_RUN_HPP
#define MOULAGE_RUN_HPP

#include "owners.hpp"

namespace moulage {

/** A computation under way; leaving its scope cancels it and waits for its end. */
class Run : public Owner<MlgRun, mlg_run_free> {
public:
    using Owner::Owner;
    MlgProgress poll() const { return filled<MlgProgress>(mlg_run_poll, as_const()); }
    void cancel() const { mlg_run_cancel(as_const()); }
    /** Waits for the end, so many seconds at most, and tells whether it has come. */
    bool wait_for(double seconds) const {
        std::uint32_t state = MLG_RUN_RUNNING;
        call(mlg_run_wait_for, as_const(), seconds, &state);
        return state == MLG_RUN_ENDED;
    }
    /** The latest shape; empty before the first one. */
    std::vector<double> preview() const {
        std::vector<double> points;
        std::size_t count = 0;
        do {
            points.resize(3 * count);
            call(mlg_run_preview_points, as_const(), points.data(), points.size() / 3, &count);
        } while (3 * count > points.size());
        points.resize(3 * count);
        return points;
    }
};

/** A run that makes a `Result`. */
template <class Result> class RunOf : public Run {
public:
    using Run::Run;
    /** Waits for the end and hands the result over, once. */
    Result wait() const { return Result::of(*this); }
};

}  // namespace moulage

#endif
