#include "daemon/progress/progress_keeper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// A write that takes longer while the print goes on is reported.
constexpr std::chrono::seconds kSlowWrite{1};
// The end of a pause waits for the disk at most this long.
constexpr std::chrono::seconds kMostPatience{10};

// Calls `change`, and returns why it failed; empty if it did not.
template <typename Change>
std::string trouble_of(const Change& change) {
  try {
    change();
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

ProgressKeeper::ProgressKeeper(EventLoop& loop, const Log& log, std::filesystem::path file,
                               std::function<bool()> lit)
    : loop_(loop),
      log_(log),
      lit_(std::move(lit)),
      record_(std::make_shared<ProgressRecord>(std::move(file))),
      worker_(loop, "contourd-place") {}

void ProgressKeeper::begin(JobProgress progress, std::function<JobMarks()> marks) {
  progress.written = std::chrono::system_clock::now();
  progress_ = progress;
  reported_ = waiting_ = false;
  begin_writing();
  struct Begun {
    JobMarks marks;
    std::string trouble;
  };
  worker_.run(
      [record = record_, progress, marks = std::move(marks)]() mutable {
        progress.marks = marks();
        return Begun{progress.marks, trouble_of([&] { record->begin(progress); })};
      },
      [this](const Begun& begun) {
        if (progress_) progress_->marks = begun.marks;
        written(begun.trouble);
      });
}

void ProgressKeeper::go_on(JobProgress progress) {
  progress_ = std::move(progress);
  reported_ = waiting_ = false;
  begin_writing();
  worker_.run([record = record_] { return trouble_of([&] { record->go_on(); }); },
              [this](const std::string& trouble) { written(trouble); });
}

void ProgressKeeper::keep(const PrintProgress& print) {
  if (!progress_) return;
  if (print.layer > progress_->print.layer) progress_->lit += progress_->print.light;
  progress_->print = print;
  progress_->written = std::chrono::system_clock::now();
  const bool slow = waiting_ && std::chrono::steady_clock::now() - write_began_ > kSlowWrite;
  if (slow && !std::exchange(reported_, true))
    log_.warning("progress",
                 "the disk is slower than the print: after a power cut now, contourd would not know exactly "
                 "how far the print was");
  waiting_ = true;
  write();
}

void ProgressKeeper::change(JobProgress::Changes changes) {
  if (!progress_) return;
  progress_->changes = std::move(changes);
  waiting_ = true;
  write();
}

void ProgressKeeper::begin_writing() {
  writing_ = true;
  write_began_ = std::chrono::steady_clock::now();
}

void ProgressKeeper::write() {
  if (writing_ || !waiting_ || lit_()) return;
  begin_writing();
  waiting_ = false;
  worker_.run(
      [record = record_, progress = *progress_] { return trouble_of([&] { record->write(progress); }); },
      [this](const std::string& trouble) { written(trouble); });
}

void ProgressKeeper::written(const std::string& trouble) {
  writing_ = false;
  if (!progress_) return answer_left(true);
  if (trouble.empty()) {
    write();
    if (!writing_) answer_left(true);
    return;
  }
  if (!std::exchange(reported_, true))
    log_.error("progress", fmt::format("the progress of the print cannot be recorded, so that it could not "
                                       "go on after a power cut: {}",
                                       printable(trouble)));
  answer_left(true);
}

void ProgressKeeper::leave_pause(Left left) {
  if (!progress_ || progress_->print.phase != PrintPhase::Paused) return left(true);
  answer_left(false);
  left_ = std::move(left);
  left_deadline_ = loop_.at(std::chrono::steady_clock::now() + kMostPatience, "a pause's end",
                            [this] { answer_left(false); });
  PrintProgress leaving = progress_->print;
  if (leaving.plate) leaving.plate->least = std::min(leaving.bottom, leaving.plate->most);
  keep(leaving);
}

void ProgressKeeper::answer_left(bool recorded) {
  left_deadline_.reset();
  if (const Left left = std::exchange(left_, nullptr)) left(recorded);
}

void ProgressKeeper::end() {
  if (!std::exchange(progress_, std::nullopt)) return;
  waiting_ = false;
  worker_.run(
      [record = record_] {
        record->end();
        return true;
      },
      [](bool) {});
}

}  // namespace contourd
