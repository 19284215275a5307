// The projector's power and light. Not thread-safe: calls and callbacks happen on the event loop's thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace contourd {

enum class ProjectorReply {
  Ok,
  Refused,   // it answered, and said no
  NoAnswer,  // it did not answer in time, retries included
};
[[nodiscard]] std::string_view describe(ProjectorReply reply);

// What a projector says of itself.
struct ProjectorStatus {
  ProjectorReply reply = ProjectorReply::Ok;  // to the first question that went wrong, if one did
  std::string problem;                        // that, in a sentence
  std::optional<bool> powered;                // nothing where it cannot be asked
  std::optional<std::int64_t> lamp_hours;     // the same
};

class Projector {
 public:
  using Done = std::function<void(ProjectorReply)>;

  Projector() = default;
  Projector(const Projector&) = delete;
  Projector& operator=(const Projector&) = delete;
  virtual ~Projector() = default;

  // Power on, then wait until the lamp is warm. The light stays off. Returns at once; may take minutes.
  virtual void power_on(Done done) = 0;

  // Light on. Returns at once. REQUIRES: powered on; no other light_on() waits for its `done`.
  virtual void light_on(Done done) = 0;

  // Light off, now, whatever else was asked; a waiting `done` is dropped. Harmless when it is off already.
  virtual void light_off() noexcept = 0;

  // Light off and power off. The lamp may cool down for a while by itself.
  virtual void power_off() noexcept = 0;

  // Asks the projector what it can be asked, and changes nothing. Returns at once. light_off() drops `done`.
  using StatusDone = std::function<void(const ProjectorStatus&)>;
  virtual void ask_status(StatusDone done) = 0;

  // The last reply that was not Ok, in a sentence with the port and what came back.
  [[nodiscard]] virtual std::string last_problem() const = 0;

  // Why the light may be on though it is to be off, in a sentence; empty when it is off as far as anybody can
  // tell. To be asked when no light is wanted.
  [[nodiscard]] virtual std::string doubt() const { return {}; }
};

}  // namespace contourd
