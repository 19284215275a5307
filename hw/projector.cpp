#include "hw/projector.hpp"

namespace contourd {

std::string_view describe(ProjectorReply reply) {
  switch (reply) {
    case ProjectorReply::Ok:
      return "ok";
    case ProjectorReply::Refused:
      return "the projector refused the command";
    case ProjectorReply::NoAnswer:
      return "the projector does not answer";
    case ProjectorReply::Interlocked:
      return "the light is kept off";
  }
  return "unknown";
}

}  // namespace contourd
