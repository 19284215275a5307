// The running contourd, for contourctl setup. Each request uses its own connection, whose end also stops the
// operation. Not thread-safe; blocks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/dialog.hpp"

namespace contourd::ctl {

class SetupDaemon {
 public:
  using Json = DaemonConnection::Json;

  // Both references must outlive this object.
  SetupDaemon(const ClientOptions& client, Dialog& dialog) : client_(client), dialog_(dialog) {}

  // Restarts contourd with this configuration: by systemd if the file is the service's, else by asking the
  // user. Returns true once a new contourd with this printer name answers, and false if the user skips that.
  bool restart(const std::filesystem::path& config, const std::string& name);

  // Calls a method and returns its result. Throws DaemonError, also if contourd refuses.
  [[nodiscard]] Json ask(const char* method, const Json& parameters = Json::object()) const;
  // Runs a manual operation to its end, and prints its phases and problems. If it fails, throws DaemonError
  // with the sentence `failure`.
  void control(const char* method, const Json& parameters, const char* failure) const;
  // Shows the pattern, lit for this time. Throws DaemonError.
  void light(const char* pattern, double seconds) const;

  // Returns the limit switch as in the answer of the method `inputs`. Throws DaemonError, also if the switch
  // cannot be read.
  [[nodiscard]] Json limit_switch() const;
  // Returns a number of the status of manual control: "height_mm" of the plate, or nullopt if it is unknown;
  // "homing_shift_um" of the switch, or nullopt if no steps were counted before the last homing.
  [[nodiscard]] std::optional<double> by_hand(const char* field) const;

 private:
  [[nodiscard]] std::optional<DaemonConnection> connect() const;
  bool restart_service();
  bool answers_as(const std::string& name);

  const ClientOptions& client_;
  Dialog& dialog_;
};

}  // namespace contourd::ctl
