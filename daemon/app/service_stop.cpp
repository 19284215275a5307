#include "daemon/app/service_stop.hpp"

#include <fmt/format.h>

#include <chrono>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Time that a stop waits for a print to be filed; the service manager waits longer (contourd.service).
constexpr Duration kLongestFiling = std::chrono::seconds{15};

}  // namespace

void ServiceStop::begin(Ending ending) {
  ending_ = ending;
  parts_.scheduler.stop();
  parts_.manual.stop();
  parts_.manual.hide();
}

void ServiceStop::shut_down(const std::string& reason) {
  begin(Ending::ShutDown);
  parts_.reader.stop();
  parts_.job.stop(reason);
  try_to_stop();
}

void ServiceStop::hand_over_when_idle() {
  const CurrentJob& job = parts_.job;
  const bool prints = job.print().under_way() || job.finishing();
  context_.log.info("restart", prints
                                   ? fmt::format("contourd restarts when {} is over", printable(job.name()))
                                   : "contourd restarts");
  begin(Ending::HandOver);
  try_to_stop();
}

// Does nothing until the current print has ended: the loop must run to turn its light off.
void ServiceStop::try_to_stop() {
  CurrentJob& job = parts_.job;
  if (ending_ == Ending::No || job.print().under_way() || parts_.manual.in_use()) return;
  if (ending_ == Ending::HandOver && job.finishing()) return;  // called again after filing
  job.stop_analysis();
  // A job that is still being read waits for the next start: nothing was printed.
  if (job.job() != nullptr && !job.is_being_filed()) job.give_back();
  if (job.is_being_filed()) {
    if (!timer_)
      timer_ = context_.loop.at(std::chrono::steady_clock::now() + kLongestFiling, "the stop's timer",
                                [this] { stop_waiting_for_filing(); });
    return;
  }
  if (parts_.scheduler.claiming()) return parts_.spool.stop_copying();  // called again after it
  context_.loop.stop();
}

// The archivist still completes the filing that has begun, or the next start does.
void ServiceStop::stop_waiting_for_filing() {
  const std::string& name = parts_.job.name();
  context_.log.error(
      "stopped",
      fmt::format("{}: not filed after {:.0f} s: the disk does not answer, or this computer is too slow",
                  printable(name), milliseconds(kLongestFiling) / 1000),
      job_fields(name));
  context_.loop.stop();
}

}  // namespace contourd
