// Passes the jobs that arrive in incoming/ or leave it to the queue, and logs everything else that happens
// there. Event loop's thread only.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/jobs/print_queue.hpp"
#include "daemon/spool/incoming_watch.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

class IncomingRouter final : public SpoolObserver {
 public:
  // Log and queue must outlive the router. The queue may be constructed later, but before the first call.
  IncomingRouter(const Log& log, PrintQueue& queue) : log_(log), queue_(queue) {}

  void model_arrived(const std::string& file) override { queue_.arrived(file); }
  void model_withdrawn(const std::string& file) override { queue_.withdrawn(file); }
  void plate_waits(const std::string& file, const std::vector<std::string>& missing) override;
  void ignored(const std::string& file, WhyIgnored why) override;
  void more_ignored(std::size_t files) override;
  void incoming_lost(const std::string& why) override;
  void incoming_replaced() override;

 private:
  const Log& log_;
  PrintQueue& queue_;
};

}  // namespace contourd
