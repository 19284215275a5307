#include "daemon/print_queue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/readable.hpp"

namespace contourd {

PrintQueue::PrintQueue(const Log& log, Calls calls)
    : log_(log), calls_(std::move(calls)), order_(calls_.keep_order, [&log](const std::string& trouble) {
        log.warning("queue",
                    fmt::format("the queue's order will be lost with a restart: {}", printable(trouble)));
      }) {}

PrintQueue::Position PrintQueue::find(const std::string& file) {
  return std::ranges::find(jobs_, file, &WaitingJob::file);
}

void PrintQueue::arrived(const std::string& file) {
  const Position queued = find(file);
  if (queued != jobs_.end() && queued->check == WaitingJob::Check::Refused) {
    // What lies there goes to failed/, unless it was written anew: rejected() knows.
    queued->withdrawn = false;
    queued->seen_again = true;
    return;
  }
  WaitingJob job{.file = file, .arrived = std::chrono::steady_clock::now()};
  if (queued != jobs_.end()) {
    job.trouble = std::move(queued->trouble);  // told already
    *queued = std::move(job);
    calls_.forget(file);
  } else {
    const std::size_t place =
        order_.place_of(file, jobs_, [](const WaitingJob& each) { return std::string_view(each.file); });
    jobs_.insert(jobs_.begin() + static_cast<std::ptrdiff_t>(place), std::move(job));
    log_.info("queued", fmt::format("{}: arrived, number {} in the queue", printable(file), place + 1),
              file_fields(file));
  }
  calls_.changed();
}

void PrintQueue::withdrawn(const std::string& file) {
  const Position job = find(file);
  if (job == jobs_.end()) return order_.remove(file);
  if (job->check == WaitingJob::Check::Refused) {
    // Most likely the spool took it: rejected() knows.
    job->withdrawn = true;
    return;
  }
  remove_withdrawn(job);
}

void PrintQueue::remove_withdrawn(const Position& job) {
  const std::string file = job->file;
  jobs_.erase(job);
  order_.remove(file);
  calls_.forget(file);
  tell_withdrawn(log_, file);
  calls_.changed();
}

void PrintQueue::check_next() {
  const Position wanted = std::ranges::find(jobs_, WaitingJob::Check::Wanted, &WaitingJob::check);
  if (wanted == jobs_.end()) return;
  wanted->check = WaitingJob::Check::Running;
  const std::uint64_t number = wanted->check_number = ++checks_begun_;
  const auto keep = wanted == jobs_.begin() ? JobReader::Keep::Prepared : JobReader::Keep::Nothing;
  calls_.check(wanted->file, keep, [this, file = wanted->file, number](const CheckedJob& found) {
    checked(file, number, found);
  });
}

void PrintQueue::checked(const std::string& file, std::uint64_t number, const CheckedJob& found) {
  const Position job = find(file);
  // Gone, or written again meanwhile: what was found out is about another file.
  if (job != jobs_.end() && job->check == WaitingJob::Check::Running && job->check_number == number) {
    const auto* const refusal = std::get_if<JobRefusal>(&found);
    if (refusal != nullptr && !refusal->for_now && refusal->profile.empty())
      return leave(*job, refusal->reason, Leaving::Refused);
    note_check(*job, found);
  }
  calls_.changed();
}

// Of a job that stays.
void PrintQueue::note_check(WaitingJob& job, const CheckedJob& found) {
  const auto* const refusal = std::get_if<JobRefusal>(&found);
  if (refusal != nullptr && refusal->for_now) return postpone(job, refusal->reason);
  job.check = WaitingJob::Check::Passed;
  job.postponed.clear();
  if (refusal == nullptr) {
    job.outlook = std::get<JobOutlook>(found);
    return;
  }
  // When its turn comes, the profile is read again.
  log_.warning("profile", fmt::format("{}: {}", printable(job.file), printable(refusal->profile)),
               file_fields(job.file));
}

void PrintQueue::postpone(WaitingJob& job, const std::string& why) {
  job.check = WaitingJob::Check::Postponed;
  // Its figures change all the time.
  if (!std::exchange(job.postponed, why).empty()) return;
  log_.info(
      "postponed",
      fmt::format("{}: is read later, because there is not enough memory now: {}", printable(job.file), why),
      file_fields(job.file));
}

void PrintQueue::check_postponed() {
  for (WaitingJob& job : jobs_) {
    if (job.check == WaitingJob::Check::Postponed) job.check = WaitingJob::Check::Wanted;
  }
}

bool PrintQueue::first_may_begin() const {
  expects(!empty(), "a job waits");
  return jobs_.front().check != WaitingJob::Check::Running && rejections_ == 0;
}

WaitingJob PrintQueue::take_first() {
  expects(!empty(), "a job waits");
  WaitingJob job = std::move(jobs_.front());
  jobs_.pop_front();
  return job;
}

void PrintQueue::put_last(WaitingJob job) {
  order_.remove(job.file);
  calls_.forget(job.file);
  jobs_.push_back(std::move(job));
}

void PrintQueue::refuse_first(const std::string& reason) {
  expects(!empty(), "a job waits");
  leave(jobs_.front(), reason, Leaving::Refused);
}

void PrintQueue::remove(const std::string& file, const std::string& reason) {
  const Position job = find(file);
  expects(job != jobs_.end() && job->check != WaitingJob::Check::Refused, "the job waits");
  calls_.forget(file);
  leave(*job, reason, Leaving::Removed);
}

void PrintQueue::move(const std::string& file, std::size_t to) {
  const Position job = find(file);
  expects(job != jobs_.end(), "the job waits");
  const auto from = static_cast<std::size_t>(job - jobs_.begin());
  to = std::min(to, jobs_.size() - 1);
  expects(std::max(from, to) < kMostInOrder, "the places are among the first");
  if (from == to) return;
  std::vector<std::string_view> first;
  for (std::size_t i = 0; i <= std::max(from, to); ++i)
    first.push_back(jobs_[i].file);
  const std::size_t next = to < from ? to : to + 1;
  order_.move(file, next < jobs_.size() ? std::optional(jobs_[next].file) : std::nullopt, first);
  WaitingJob moved = std::move(*job);
  moved.waited = true;
  jobs_.erase(job);
  jobs_.insert(jobs_.begin() + static_cast<std::ptrdiff_t>(to), std::move(moved));
  log_.info("moved", fmt::format("{}: number {} in the queue now", printable(file), to + 1),
            file_fields(file));
  calls_.changed();
}

void PrintQueue::leave(WaitingJob& job, const std::string& reason, Leaving how) {
  job.check = WaitingJob::Check::Refused;
  ++rejections_;
  calls_.reject(
      job.file, reason + "\n",
      [this, reject = Reject{job.file, reason, how}](Spool::Rejection rejection, const std::string& trouble) {
        rejected(reject, rejection, trouble);
      });
}

void PrintQueue::rejected(const Reject& reject, Spool::Rejection rejection, const std::string& trouble) {
  --rejections_;
  const Position job = std::ranges::find_if(jobs_, [&](const WaitingJob& each) {
    return each.file == reject.file && each.check == WaitingJob::Check::Refused;
  });
  if (rejection == Spool::Rejection::Unfinished) {
    if (reject.how == Leaving::Removed)
      log_.warning(
          "removed",
          fmt::format("{}: stays in the queue, because somebody is writing it anew", printable(reject.file)),
          file_fields(reject.file));
    return not_rejected(job);
  }
  if (job != jobs_.end()) {
    jobs_.erase(job);
    order_.remove(reject.file);
  }
  tell_rejected(reject, rejection, trouble);
  (reject.how == Leaving::Refused ? calls_.refused : calls_.removed)(reject.file, reject.reason);
  calls_.changed();
}

// It is checked again when it is whole.
void PrintQueue::not_rejected(const Position& job) {
  if (job != jobs_.end()) {
    if (job->withdrawn) return remove_withdrawn(job);
    job->check = job->seen_again ? WaitingJob::Check::Wanted : WaitingJob::Check::Passed;
    job->seen_again = false;
  }
  calls_.changed();
}

void PrintQueue::tell_rejected(const Reject& job, Spool::Rejection rejection,
                               const std::string& trouble) const {
  const std::string file = printable(job.file);
  const bool removed = job.how == Leaving::Removed;
  const std::string_view event = removed ? "removed" : "refused";
  log_.write(removed ? LogLevel::Info : LogLevel::Error, event, fmt::format("{}: {}", file, job.reason),
             file_fields(job.file));
  if (rejection == Spool::Rejection::LeftThere)
    log_.warning(event,
                 fmt::format("{}: stays in incoming, because it cannot be moved; it may be deleted", file),
                 file_fields(job.file));
  if (rejection == Spool::Rejection::Impossible)
    log_.error(event, fmt::format("{}: cannot be moved to failed: {}", file, printable(trouble)));
}

LogFields file_fields(const std::string& file) {
  return job_fields(job_name_of(file));
}

void tell_withdrawn(const Log& log, const std::string& file) {
  log.info("withdrawn", fmt::format("{}: taken away by the owner", printable(file)), file_fields(file));
}

}  // namespace contourd
