#include "daemon/web/web_login.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/web/request_checks.hpp"

namespace contourd::web {
namespace {

using std::chrono::steady_clock;

constexpr const char* kCookie = "contourd";

std::string token_of(const HttpRequest& request) {
  return cookie_of(request.header("Cookie"), kCookie);
}

// Returns the value of Set-Cookie. A browser sends the cookie with requests of the printer's own page only,
// and shows it to no script.
std::string cookie_with(const HttpRequest& request, const std::string& token, std::chrono::seconds lifetime) {
  // A reverse proxy on this computer reports that the browser's connection is encrypted.
  const bool encrypted = request.header("X-Forwarded-Proto") == "https";
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict; Max-Age={}{}", kCookie, token,
                     lifetime.count(), encrypted ? "; Secure" : "");
}

}  // namespace

WebLogin::WebLogin(EventLoop& loop, WebSecrets secrets, std::chrono::seconds session, Report report)
    : secrets_(std::move(secrets)),
      sessions_(session),
      report_(std::move(report)),
      worker_(loop, "web-login") {}

std::optional<Role> WebLogin::role_of(const HttpRequest& request) const {
  return sessions_.role_of(token_of(request), steady_clock::now());
}

std::function<bool()> WebLogin::session_of(const HttpRequest& request) const {
  return
      [this, token = token_of(request)] { return sessions_.role_of(token, steady_clock::now()).has_value(); };
}

bool WebLogin::has_key(const HttpRequest& request) const {
  return equal_in_constant_time(request.header("X-Api-Key"), secrets_.key);
}

DigestCheck WebLogin::digest_of(const HttpRequest& request) const {
  return request.is_open() ? check_digest(request.connection(), secrets_.key) : DigestCheck::Absent;
}

void WebLogin::log_in(const std::shared_ptr<HttpRequest>& request, const std::string& body) {
  const auto now = steady_clock::now();
  if (const auto wait = guard_.wait_of(request->peer(), now); wait.count() > 0) {
    return request->answer(
        {.status = 429,
         .body = fmt::format("too many wrong passwords: wait {} s, then try again\n", wait.count()),
         .headers = {{"Retry-After", std::to_string(wait.count())}}});
  }
  const auto json = nlohmann::json::parse(body, nullptr, false);
  if (!json.is_object() || !json.contains("password") || !json["password"].is_string())
    return request->answer({.status = 400, .body = "expected {\"password\": \"...\"}\n"});
  if (checks_ >= kMostChecks)
    return request->answer({.status = 503, .body = "too many people log in at once: try again\n"});
  guard_.tried(request->peer(), now);
  ++checks_;
  worker_.run([password = json["password"].get<std::string>(),
               secrets = secrets_] { return role_with(password, secrets); },
              [this, request](std::optional<Role> role) { checked(request, role); });
}

void WebLogin::checked(const std::shared_ptr<HttpRequest>& request, std::optional<Role> role) {
  --checks_;
  report_(request->peer(), role);
  if (role) guard_.succeeded(request->peer());
  if (!request->is_open()) return;
  if (!role) return request->answer({.status = 401, .body = "the password is wrong\n"});
  request->has_logged_in();
  const std::string token = sessions_.open(*role, steady_clock::now());
  request->answer(
      {.status = 204, .headers = {{"Set-Cookie", cookie_with(*request, token, sessions_.lifetime())}}});
}

void WebLogin::log_out(HttpRequest& request) {
  sessions_.close(token_of(request));
  request.answer(
      {.status = 204, .headers = {{"Set-Cookie", cookie_with(request, "", std::chrono::seconds(0))}}});
}

}  // namespace contourd::web
