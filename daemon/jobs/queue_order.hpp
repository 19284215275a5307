// The order of the waiting jobs, where their owner has changed it: the names of the first of them. It is kept
// on the disk, so that it is the same after a restart. Event loop's thread only.
//
// INVARIANT: the queue's first jobs are those named here, in this order; the others came later than all of
// them. What is named and not in the queue (yet: a daemon that starts hears of one file after the other) has
// its place among them.
#pragma once

#include <cstddef>
#include <functional>
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
  using Keep = RecordKeeper::Keep;
  // As RecordKeeper's.
  QueueOrder(Keep keep, std::function<void(const std::string& trouble)> failed)
      : keeper_(std::move(keep), std::move(failed)) {}

  // What the last process has kept.
  void load(Names names) {
    keeper_.load(names);
    names_ = std::move(names);
  }
  [[nodiscard]] const Names& names() const { return names_; }

  // Where a new job belongs among these, which are in the queue's order: before the job of that number; their
  // number when it is the last.
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

  // `file` now comes right before `next`, or last without one. `first` are the queue's first jobs as they
  // were, down to where it is or was, whichever is later.
  void move(const std::string& file, const std::optional<std::string>& next,
            const std::vector<std::string_view>& first);
  // It has left the queue, or has no place of its own any more.
  void remove(const std::string& file);

 private:
  RecordKeeper keeper_;
  Names names_;
};

}  // namespace contourd
