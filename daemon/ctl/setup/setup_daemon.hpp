// contourd as contourctl setup has it do things: each by a connection of its own, which ends what it began.
// Not thread-safe; blocks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/setup/setup_dialog.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

class SetupDaemon {
 public:
  using Json = DaemonConnection::Json;

  // Both must outlive it.
  SetupDaemon(const ClientOptions& client, SetupDialog& dialog) : client_(client), dialog_(dialog) {}

  // Has it started anew with that configuration, by systemd where it is the service's, else by whoever
  // answers. True when one answers that was not there before and calls itself by that name; false when that
  // is skipped.
  bool start_anew(const std::filesystem::path& config, const std::string& name);

  // Throws DaemonError, also for what it refuses.
  [[nodiscard]] Json ask(const char* method, const Json& parameters = Json::object()) const;
  // Until it is over; what goes on and what is wrong is said. Throws DaemonError with that sentence when it
  // was not done.
  void control(const char* method, const Json& parameters, const char* otherwise) const;
  // The pattern, lit for so long. Throws DaemonError.
  void light(const char* pattern, double seconds) const;

  // As the method `inputs` has it. Throws DaemonError also when it cannot be read.
  [[nodiscard]] Json limit_switch() const;
  // Nothing when it is unknown.
  [[nodiscard]] std::optional<double> height_mm() const;
  // Of the homing that was just made; nothing when there was none before it from which steps were counted.
  [[nodiscard]] std::optional<double> homing_shift_um() const;

 private:
  [[nodiscard]] std::optional<double> by_hand(const char* field) const;
  [[nodiscard]] std::optional<DaemonConnection> connect() const;
  bool restart_service();
  bool answers_as(const std::string& name);

  const ClientOptions& client_;
  SetupDialog& dialog_;
};

}  // namespace contourd::ctl
