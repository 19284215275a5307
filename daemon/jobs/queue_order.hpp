// The order of the waiting jobs as users have changed it: the names of the first jobs of the queue. It is
// saved on the disk, so that it survives a restart. Event loop's thread only.
//
// INVARIANT: the queue's first jobs are those named here, in this order; the others arrived later than all of
// them. A name without a job in the queue keeps its place: a starting daemon learns of one file after the
// other.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/jobs/record_keeper.hpp"

namespace contourd {

class QueueOrder {
 public:
  using Names = RecordKeeper::Lines;
  // Checks and log must outlive the order.
  QueueOrder(JobChecks& checks, const Log& log) : keeper_(checks, JobChecks::Record::Order, log) {}

  // Restores the order that the last process saved.
  void load(Names names) {
    keeper_.load(names);
    names_ = std::move(names);
  }
  [[nodiscard]] const Names& names() const { return names_; }

  // Returns the place at which the new job `file` belongs among `jobs`, which are in the queue's order;
  // jobs.size() if it is the last.
  template <typename Jobs, typename FileOf>
  [[nodiscard]] std::size_t place_of(const std::string& file, const Jobs& jobs, FileOf file_of) const {
    auto name = names_.begin();
    std::size_t place = 0;
    for (auto job = jobs.begin(); job != jobs.end() && name != names_.end(); ++job, ++place) {
      for (; name != names_.end() && *name != file_of(*job); ++name)
        if (*name == file) return place;
      if (name != names_.end()) ++name;
    }
    return jobs.size();
  }

  // Places `file` right before `next`, or last if there is no `next`, and saves the order. `first` are the
  // queue's first jobs in their old order, up to the old or the new place of `file`, whichever is later.
  void move(const std::string& file, const std::optional<std::string>& next,
            const std::vector<std::string_view>& first);
  // Removes `file`, which has left the queue or lost its place, and saves the order.
  void remove(const std::string& file);

 private:
  RecordKeeper keeper_;
  Names names_;
};

}  // namespace contourd
