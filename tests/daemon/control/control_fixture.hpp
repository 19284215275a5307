// A fixture with a current job, a queue whose checks end as a test says, and the printer's status. Not
// thread-safe.
#pragma once

#include "daemon/control/printer_status.hpp"
#include "tests/daemon/jobs/current_job_fixture.hpp"
#include "tests/daemon/jobs/fake_printer.hpp"

namespace contourd::testing {

class ControlFixture : public CurrentJobFixture {
 public:
  ControlFixture() { checks.check_result = JobOutlook{}; }

  FakeChecks checks;
  FakeQueueObserver queue_observer;
  PrintQueue queue{config, checks, queue_observer, log.log};
  BlockingClaims claims{spool, config};
  JobScheduler scheduler{context, spool, claims, queue, hold, use};
  JobHistory history;
  ManualProcess manual{machine, clock, [] {}};
  ReminderConfig reminder_config;
  Reminders reminders{reminder_config};
  Camera camera{loop, log.log, config};
  PrinterStatus status{context, {spool, queue, scheduler, hold, job, history, manual, reminders, camera}};
};

}  // namespace contourd::testing
