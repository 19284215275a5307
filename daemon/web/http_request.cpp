#include "daemon/web/http_request.hpp"

#include <fmt/format.h>
#include <microhttpd.h>
#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <system_error>

#include "daemon/web/slicer_digest.hpp"

namespace contourd::web {
namespace {

using ResponsePtr = std::unique_ptr<MHD_Response, decltype(&MHD_destroy_response)>;

// Adds the headers of every reply: browsers load nothing from elsewhere, show the page in no frame of another
// site, guess no types and keep nothing.
void add_headers(MHD_Response* response, const std::string& type, const char* policy) {
  for (const auto& [name, value] : std::initializer_list<std::pair<const char*, const char*>>{
           {"Content-Type", type.c_str()},
           {"Content-Security-Policy", policy},
           {"X-Content-Type-Options", "nosniff"},
           {"X-Frame-Options", "DENY"},
           {"Referrer-Policy", "no-referrer"},
           {"Cross-Origin-Resource-Policy", "same-origin"},
           {"Cache-Control", "no-store"}})
    MHD_add_response_header(response, name, value);
}

}  // namespace

HttpRequest::HttpRequest(HttpLoop& loop, HttpClient& client, MHD_Connection* connection, std::string method,
                         std::string path)
    : loop_(loop),
      client_(&client),
      connection_(connection),
      method_(std::move(method)),
      path_(std::move(path)),
      ends_(client.ends) {
  allow_time(0);
}

std::string HttpRequest::header(const char* name) const {
  if (!is_open()) return "";
  const char* const value = MHD_lookup_connection_value(connection_, MHD_HEADER_KIND, name);
  return value == nullptr ? "" : value;
}

std::optional<std::string> HttpRequest::parameter(const char* name) const {
  if (!is_open()) return std::nullopt;
  const char* value = nullptr;
  const std::size_t bytes = std::strlen(name);
  if (MHD_lookup_connection_value_n(connection_, MHD_GET_ARGUMENT_KIND, name, bytes, &value, nullptr) !=
      MHD_YES)
    return std::nullopt;
  return value == nullptr ? "" : value;
}

bool HttpRequest::has_body() const {
  return body_bytes().value_or(0) > 0 || !header("Transfer-Encoding").empty();
}

std::optional<std::uint64_t> HttpRequest::body_bytes() const {
  const std::string text = header("Content-Length");
  std::uint64_t bytes = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bytes);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return bytes;
}

void HttpRequest::has_logged_in() {
  if (is_open()) client_->has_logged_in = true;
}

void HttpRequest::receive(std::shared_ptr<HttpBody> body, std::uint64_t most) {
  body_ = std::move(body);
  most_ = most;
}

void HttpRequest::answer(HttpReply reply) {
  if (!is_open() || has_reply()) return;
  reply_ = std::move(reply);
  go_on();
}

void HttpRequest::answer(std::shared_ptr<HttpStream> stream) {
  if (!is_open() || has_reply()) return;
  stream_ = std::move(stream);
  go_on();
}

void HttpRequest::wait() {
  if (!is_open() || std::exchange(waiting_, true)) return;
  // The time in which the client waits for this computer is not the client's.
  time_left_ = client_->deadline - std::chrono::steady_clock::now();
  client_->deadline = std::chrono::steady_clock::time_point::max();
  MHD_suspend_connection(connection_);
}

void HttpRequest::go_on() {
  if (!is_open() || !std::exchange(waiting_, false)) return;
  client_->deadline = std::chrono::steady_clock::now() + time_left_;
  MHD_resume_connection(connection_);
  loop_.run_soon();
}

void HttpRequest::allow_time(std::uint64_t bytes) {
  client_->deadline = std::max(client_->deadline, std::chrono::steady_clock::now() + kBodyTime) +
                      std::chrono::seconds(bytes / kSlowestBytesPerSecond);
}

bool HttpRequest::take(std::string_view piece) {
  const std::uint64_t before = received_;
  received_ += piece.size();
  if (!body_) return true;
  if (received_ > most_) {
    if (before <= most_) refuse_body();
    return true;
  }
  // A body has the time that the slowest rate would take, however its pieces are spread.
  client_->deadline +=
      std::chrono::seconds(received_ / kSlowestBytesPerSecond - before / kSlowestBytesPerSecond);
  if (!body_->take(piece)) wait();
  return true;
}

// libmicrohttpd takes no reply while a body arrives, so this one goes straight to the socket, on which
// nothing else is being sent. The rest of the body is discarded for a while: closing a socket with unread
// bytes would take the reply away from the client.
void HttpRequest::refuse_body() {
  constexpr std::chrono::seconds kTimeToRead{5};
  const std::string sentence = fmt::format("the body is too large: it may have at most {} bytes\n", most_);
  const std::string reply = fmt::format(
      "HTTP/1.1 413 Content Too Large\r\nConnection: close\r\nContent-Type: {}\r\nContent-Length: {}\r\n"
      "X-Content-Type-Options: nosniff\r\n\r\n{}",
      HttpReply{}.type, sentence.size(), sentence);
  (void)!::send(client_->socket, reply.data(), reply.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  client_->deadline = std::chrono::steady_clock::now() + kTimeToRead;
}

bool HttpRequest::end() {
  if (body_ && received_ > most_) return false;
  if (!std::exchange(ended_, true) && body_ && !has_reply()) body_->end();
  if (has_reply()) return send();
  wait();
  return true;
}

bool HttpRequest::send() {
  if (stream_) return send_stream();
  const std::string& body = reply_->body;
  const ResponsePtr response(
      MHD_create_response_from_buffer(body.size(), const_cast<char*>(body.data()), MHD_RESPMEM_MUST_COPY),
      MHD_destroy_response);
  if (!response) return false;
  add_headers(response.get(), reply_->type, reply_->policy);
  for (const auto& [name, value] : reply_->headers)
    MHD_add_response_header(response.get(), name.c_str(), value.c_str());
  client_->deadline = {};
  allow_time(body.size());
  if (reply_->digest_is_stale) return ask_for_digest(connection_, response.get(), *reply_->digest_is_stale);
  return MHD_queue_response(connection_, reply_->status, response.get()) == MHD_YES;
}

bool HttpRequest::send_stream() {
  constexpr std::size_t kBlock = 16384;
  const auto read = [](void* self, std::uint64_t, char* buffer, std::size_t most) {
    return static_cast<HttpRequest*>(self)->read_stream(buffer, most);
  };
  const ResponsePtr response(MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, kBlock, read, this, nullptr),
                             MHD_destroy_response);
  if (!response) return false;
  add_headers(response.get(), "text/event-stream", kPagePolicy);
  return MHD_queue_response(connection_, MHD_HTTP_OK, response.get()) == MHD_YES;
}

ssize_t HttpRequest::read_stream(char* buffer, std::size_t most) {
  if (piece_.empty() && stream_->has_ended()) return MHD_CONTENT_READER_END_OF_STREAM;
  if (piece_.empty()) piece_ = stream_->next();
  client_->deadline = std::chrono::steady_clock::now() + kBodyTime;
  if (piece_.empty()) {
    wait();
    return 0;
  }
  const std::size_t bytes = std::min(most, piece_.size());
  std::memcpy(buffer, piece_.data(), bytes);
  piece_.erase(0, bytes);
  return static_cast<ssize_t>(bytes);
}

}  // namespace contourd::web
