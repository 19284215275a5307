#include "daemon/job_history.hpp"

#include <utility>

namespace contourd {

void JobHistory::add(EndedJob job) {
  ++counts_[job.outcome];
  jobs_.push_back(std::move(job));
  if (jobs_.size() > kLongest) jobs_.pop_front();
}

}  // namespace contourd
