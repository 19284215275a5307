// Ends the service: takes no more jobs, and stops the event loop when the light is off and the current print
// is filed. Event loop's thread only.
#pragma once

#include <string>

#include "daemon/jobs/current_job.hpp"
#include "daemon/jobs/job_reader.hpp"
#include "daemon/jobs/job_scheduler.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/print/manual_process.hpp"
#include "daemon/spool/spool.hpp"

namespace contourd {

class ServiceStop {
 public:
  struct Parts {
    Spool& spool;
    JobReader& reader;
    CurrentJob& job;
    JobScheduler& scheduler;
    ManualProcess& manual;
  };
  // All must outlive this object.
  ServiceStop(const PrinterContext& context, const Parts& parts) : context_(context), parts_(parts) {}

  // See PrinterService.
  void shut_down(const std::string& reason);
  void hand_over_when_idle();
  // Stops the loop if the service is ending and there is nothing more to wait for. To be called whenever
  // something that it may wait for has ended.
  void try_to_stop();

 private:
  enum class Ending { No, HandOver, ShutDown };

  void begin(Ending ending);
  void stop_waiting_for_filing();

  const PrinterContext& context_;
  Parts parts_;
  Ending ending_ = Ending::No;
  EventLoop::SourcePtr timer_;
};

}  // namespace contourd
