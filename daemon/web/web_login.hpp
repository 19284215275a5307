// Decides who may use the printer: people who have entered a password, and slicers that send the key. Event
// loop's thread only; passwords are hashed on a worker thread.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/system/worker.hpp"
#include "daemon/web/http_request.hpp"
#include "daemon/web/login_guard.hpp"
#include "daemon/web/slicer_digest.hpp"
#include "daemon/web/web_secrets.hpp"
#include "daemon/web/web_sessions.hpp"

namespace contourd::web {

class WebLogin {
 public:
  // Gets the role of each login; nullopt if the password was wrong.
  using Report = std::function<void(const std::string& peer, std::optional<Role> role)>;

  static constexpr int kMostChecks = 4;  // passwords that wait for the worker

  WebLogin(EventLoop& loop, WebSecrets secrets, std::chrono::seconds session, Report report);

  // Returns the role of the session whose cookie the request has; nullopt without one.
  [[nodiscard]] std::optional<Role> role_of(const HttpRequest& request) const;
  // Returns a function that is true as long as the request's session is open; it must not outlive the object.
  [[nodiscard]] std::function<bool()> session_of(const HttpRequest& request) const;
  // True if the request has the key of slicers, as X-Api-Key.
  [[nodiscard]] bool has_key(const HttpRequest& request) const;
  // Checks the digest of a slicer that sends the key as a password.
  [[nodiscard]] DigestCheck digest_of(const HttpRequest& request) const;
  // Answers a request whose body is {"password": "..."}: opens a session, or refuses.
  void log_in(const std::shared_ptr<HttpRequest>& request, const std::string& body);
  // Ends the request's session and answers it.
  void log_out(HttpRequest& request);

 private:
  void checked(const std::shared_ptr<HttpRequest>& request, std::optional<Role> role);

  WebSecrets secrets_;
  WebSessions sessions_;
  LoginGuard guard_;
  Report report_;
  int checks_ = 0;
  Worker worker_;
};

}  // namespace contourd::web
