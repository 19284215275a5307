// A fixture with a current job, the objects that it needs, and an observer that records its calls. Not
// thread-safe.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "daemon/jobs/current_job.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"

namespace contourd::testing {

class CurrentJobFixture : public PrinterFixture, private JobObserver, private PrinterUse {
 public:
  CurrentJobFixture() { hold.load(); }

  // Claims incoming/`file` and begins it; creates a model of this name if there is no such file.
  void begin(const std::string& file = "part.stl") {
    if (!has("incoming/" + file)) put(Spool::Folder::Incoming, file);
    const JobFiles files = spool.begin(file);
    begin(ClaimedJob{files, read_settings(files, config), std::chrono::steady_clock::now()});
  }
  // Runs until the job has ended; calls `look` after every step.
  bool run_to_end(const std::function<void()>& look = [] {}) {
    return run_until([&] {
      look();
      return !ended.empty();
    });
  }

  std::vector<EndedJob> ended;
  std::vector<std::string> events;  // the other calls of the observer

 private:
  void print_state_changed(const PrintState& state) override {
    events.push_back("state: " + std::string(state.name));
  }
  void job_changed(const std::string& what) override { events.push_back("changed: " + what); }
  void job_ended(EndedJob end) override {
    CHECK(job.job() == nullptr);  // its memory is freed
    ended.push_back(std::move(end));
  }
  void may_stop() override { events.emplace_back("may stop"); }

  [[nodiscard]] bool has_job() const override { return job.job() != nullptr; }
  [[nodiscard]] bool controlled_by_hand() const override { return false; }
  void begin(ClaimedJob claimed) override { job.begin(std::move(claimed)); }
  void hold_changed() override {}
  void left_job_filed(const EndedJob& /*job*/) override {}

 public:
  PrinterUse& use = *this;
  JobReader reader{config, spool, loop};
  QueueHold hold{context, spool, use};
  HistoryWorker past{loop, log.log, folder.path() / "history.sqlite", spool.ends()};
  CurrentJob job{context, spool, reader, hold, past, *this};
};

}  // namespace contourd::testing
