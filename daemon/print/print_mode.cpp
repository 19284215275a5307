#include "daemon/print/print_mode.hpp"

namespace contourd {

std::string_view name_of(PrintActivity activity) {
  switch (activity) {
    case PrintActivity::Preparing:
      return "preparing";
    case PrintActivity::Exposing:
      return "exposing";
    case PrintActivity::Moving:
      return "moving";
    case PrintActivity::Waiting:
      return "waiting";
    case PrintActivity::Stopped:
      return "stopped";
  }
  return "?";
}

std::string_view name_of(PrintOutcome outcome) {
  switch (outcome) {
    case PrintOutcome::Done:
      return "done";
    case PrintOutcome::Canceled:
      return "cancelled";
    case PrintOutcome::Failed:
      return "failed";
  }
  return "?";
}

}  // namespace contourd
