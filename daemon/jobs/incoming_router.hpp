// Tells the queue of the jobs that come to incoming/ and go, and the log of what else is seen there. Event
// loop's thread only.
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
  // Both must outlive it; the queue need not be made before something is there.
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
