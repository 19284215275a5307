#include "daemon/spool/job_ends.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <random>
#include <span>
#include <system_error>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using std::chrono::milliseconds;
using std::chrono::system_clock;

constexpr std::array kConsumers{EndConsumer::Files, EndConsumer::History, EndConsumer::Notice};
// Letters of the record for the consumers that an end waits for.
constexpr std::string_view kLetters = "fhn";
// The names of JobEnd::Kind.
constexpr std::array<std::string_view, 3> kKinds{"printed", "refused", "interrupted"};
constexpr std::size_t kLongestReason = 1'000;  // bytes
// The latest time that the clock can represent.
constexpr std::int64_t kLatestMs =
    std::chrono::duration_cast<milliseconds>(system_clock::duration::max()).count();

// The fields of an end in the record.
enum Field : std::size_t {
  Key,
  Job,
  Outcome,
  Reason,
  EndedMs,
  Kind,
  File,
  Mark,
  ChangedNs,
  Consumers,
  Figures,
  kFields
};

char letter_of(EndConsumer consumer) {
  return kLetters[static_cast<std::size_t>(consumer)];
}

// Returns the reason as the record has it: without NULs, which end a field, and shortened once, so that each
// process reads and writes the same text.
std::string recorded_reason(std::string reason) {
  constexpr std::size_t kNote = 40;  // bytes for the note about the rest
  std::erase(reason, '\0');
  return reason.size() <= kLongestReason ? reason : shortened(reason, kLongestReason - kNote);
}

void append_fields(const JobEndRecord::Pending& pending, std::vector<std::string>& texts) {
  const JobEnd& end = pending.end;
  const std::int64_t ended_ms =
      std::chrono::duration_cast<milliseconds>(end.ended.time_since_epoch()).count();
  std::string consumers;
  for (const EndConsumer consumer : pending.consumers)
    consumers += letter_of(consumer);
  texts.insert(texts.end(),
               {std::to_string(end.key), end.job, end.outcome, recorded_reason(end.reason),
                std::to_string(ended_ms), std::string(kKinds[static_cast<std::size_t>(end.kind)]), end.file,
                end.mark, std::to_string(end.changed_ns), consumers, end.figures});
}

std::optional<std::int64_t> integer_in(const std::string& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool is_file_name(const std::string& name) {
  return name.find('/') == std::string::npos && name != "." && name != "..";
}

// Returns nullopt if contourd did not write these fields.
std::optional<JobEndRecord::Pending> pending_in(std::span<const std::string> fields) {
  const std::optional<std::int64_t> key = integer_in(fields[Key]), ended_ms = integer_in(fields[EndedMs]),
                                    changed_ns = integer_in(fields[ChangedNs]);
  const std::string& outcome = fields[Outcome];
  const auto kind = std::ranges::find(kKinds, fields[Kind]);
  if (!key || *key == 0 || !ended_ms || *ended_ms < 0 || *ended_ms > kLatestMs || !changed_ns ||
      kind == kKinds.end() || fields[Job].empty() || !is_file_name(fields[Job]) ||
      !is_file_name(fields[File]) || (outcome != "done" && outcome != "cancelled" && outcome != "failed"))
    return std::nullopt;
  JobEndRecord::Pending pending{{.key = *key,
                                 .job = fields[Job],
                                 .outcome = outcome,
                                 .reason = recorded_reason(fields[Reason]),
                                 .ended = system_clock::time_point(milliseconds(*ended_ms)),
                                 .kind = static_cast<JobEnd::Kind>(kind - kKinds.begin()),
                                 .file = fields[File],
                                 .mark = fields[Mark],
                                 .changed_ns = *changed_ns,
                                 .figures = fields[Figures]},
                                {}};
  for (const EndConsumer consumer : kConsumers)
    if (fields[Consumers].find(letter_of(consumer)) != std::string::npos)
      pending.consumers.push_back(consumer);
  return pending;
}

bool is_in_printing(const JobEndRecord::Pending& pending, std::string_view job) {
  return pending.end.job == job && pending.end.file.empty() && pending.awaits(EndConsumer::Files);
}

}  // namespace

std::int64_t new_job_key() {
  std::random_device chance;
  const auto key = static_cast<std::int64_t>(std::uint64_t{chance()} << 32 | chance());
  return key != 0 ? key : 1;
}

JobEnd interruption(std::int64_t key, const std::string& job) {
  return {.key = key,
          .job = job,
          .outcome = "failed",
          .reason = "The print was interrupted: " + std::string(kWhyInterrupted),
          .ended = system_clock::now(),
          .kind = JobEnd::Kind::Interrupted};
}

bool JobEndRecord::Pending::awaits(EndConsumer consumer) const {
  return std::ranges::find(consumers, consumer) != consumers.end();
}

JobEndRecord::JobEndRecord(const StateRecords& records) : records_(records) {
  const std::vector<std::string> texts = records.job_ends();
  for (std::size_t at = 0; at + kFields <= texts.size() && ends_.size() < kMost; at += kFields) {
    if (std::optional<Pending> pending = pending_in(std::span(texts).subspan(at, kFields)))
      ends_.push_back(*std::move(pending));
  }
  note_saved();
}

void JobEndRecord::add(const JobEnd& end) {
  const std::lock_guard lock(mutex_);
  const auto known =
      std::ranges::find_if(ends_, [&](const Pending& each) { return each.end.key == end.key; });
  if (known == ends_.end()) {
    if (ends_.size() == kMost) ends_.erase(ends_.begin());
    ends_.push_back({end, {kConsumers.begin(), kConsumers.end()}});
    saved_ = false;
  } else if (known->end.kind == JobEnd::Kind::Interrupted) {
    known->end = end;
    saved_ = false;
  }
  save();
}

void JobEndRecord::taken(std::int64_t key, EndConsumer consumer) {
  const std::lock_guard lock(mutex_);
  const auto end = std::ranges::find_if(ends_, [&](const Pending& each) { return each.end.key == key; });
  if (end != ends_.end()) take(end, consumer);
}

void JobEndRecord::files_taken(std::string_view job) {
  const std::lock_guard lock(mutex_);
  const auto end =
      std::ranges::find_if(ends_, [&](const Pending& each) { return is_in_printing(each, job); });
  if (end != ends_.end()) take(end, EndConsumer::Files);
}

// Does not write the record while other consumers wait, except for a notice, which would be sent again: the
// next process finds the files where they are, and the history recognises the key.
void JobEndRecord::take(Position end, EndConsumer consumer) {
  std::erase(end->consumers, consumer);
  if (end->consumers.empty())
    ends_.erase(end);
  else if (consumer != EndConsumer::Notice)
    return;
  saved_ = false;
  save_if_possible();
}

void JobEndRecord::drop(std::int64_t key) {
  const std::lock_guard lock(mutex_);
  saved_ = std::erase_if(ends_, [&](const Pending& each) { return each.end.key == key; }) == 0 && saved_;
  save_if_possible();
}

void JobEndRecord::release_name(std::string_view job) {
  const std::lock_guard lock(mutex_);
  for (Pending& each : ends_)
    if (each.end.job == job) std::erase(each.consumers, EndConsumer::Files);
  std::erase_if(ends_, [](const Pending& each) { return each.consumers.empty(); });
  // A full disk must not keep a job waiting whose name is not in the record.
  if (!unfiled_on_disk_.contains(job)) return;
  saved_ = false;
  save();
}

std::optional<JobEnd> JobEndRecord::end_of(std::string_view job) const {
  const std::lock_guard lock(mutex_);
  const auto end =
      std::ranges::find_if(ends_, [&](const Pending& each) { return is_in_printing(each, job); });
  return end == ends_.end() ? std::nullopt : std::optional(end->end);
}

std::vector<JobEndRecord::Pending> JobEndRecord::pending() const {
  const std::lock_guard lock(mutex_);
  return ends_;
}

void JobEndRecord::save() {
  if (saved_) return;
  std::vector<std::string> texts;
  for (const Pending& each : ends_)
    append_fields(each, texts);
  records_.keep_job_ends(texts);
  note_saved();
}

void JobEndRecord::note_saved() {
  saved_ = true;
  unfiled_on_disk_.clear();
  for (const Pending& each : ends_)
    if (each.awaits(EndConsumer::Files)) unfiled_on_disk_.insert(each.end.job);
}

void JobEndRecord::save_if_possible() {
  try {
    save();
  } catch (const std::system_error&) {
    // The next write contains the change.
  }
}

}  // namespace contourd
