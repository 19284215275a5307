// A request of a client of the HTTP server, and its reply. Event loop's thread only.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

struct MHD_Connection;

namespace contourd::web {

class HttpServer;

// The time for a body or a reply, and the rate at which a longer one has to go on.
inline constexpr std::chrono::seconds kBodyTime{30};
inline constexpr std::uint64_t kSlowestBytesPerSecond = 16384;

// The Content-Security-Policy of every reply, unless it has its own.
inline constexpr const char* kPagePolicy =
    "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'self'; object-src 'none'";

struct HttpReply {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body{};
  std::vector<std::pair<std::string, std::string>> headers{};
  // Asks for a digest (401); true if the last one was only too old.
  std::optional<bool> digest_is_stale{};
  const char* policy = kPagePolicy;
  std::shared_ptr<const void> place{};  // released when the reply was sent
};

// Receives the body of a request.
class HttpBody {
 public:
  virtual ~HttpBody() = default;
  // Takes the next piece. Returns false if the next one has to wait for HttpRequest::go_on().
  [[nodiscard]] virtual bool take(std::string_view piece) = 0;
  // The body is complete.
  virtual void end() = 0;
};

// Produces a reply whose end is not known beforehand.
class HttpStream {
 public:
  virtual ~HttpStream() = default;
  // Returns the next piece. Empty: there is none before HttpRequest::go_on().
  [[nodiscard]] virtual std::string next() = 0;
  // True if the reply is complete; asked before each piece.
  [[nodiscard]] virtual bool has_ended() const = 0;
};

// The ends of a connection: the client, and this computer as the client reached it.
struct HttpEnds {
  std::string peer, local;  // addresses without ports
};

// A connection, with the time by which its client has to have done its part.
struct HttpClient {
  int socket = -1;
  HttpEnds ends{};
  std::chrono::steady_clock::time_point since{}, deadline{};
  bool has_logged_in = false;
  bool cut_off = false;
};

// Serves requests; told when one that has waited can go on.
class HttpLoop {
 public:
  HttpLoop() = default;
  HttpLoop(const HttpLoop&) = delete;
  HttpLoop& operator=(const HttpLoop&) = delete;
  virtual ~HttpLoop() = default;
  virtual void run_soon() = 0;
};

class HttpRequest {
 public:
  HttpRequest(HttpLoop& loop, HttpClient& client, MHD_Connection* connection, std::string method,
              std::string path);
  ~HttpRequest() = default;
  HttpRequest(const HttpRequest&) = delete;
  HttpRequest& operator=(const HttpRequest&) = delete;

  [[nodiscard]] const std::string& method() const { return method_; }
  // Returns the path without its query, with %-sequences decoded.
  [[nodiscard]] const std::string& path() const { return path_; }
  // Returns a header; empty if there is none, or the connection is closed.
  [[nodiscard]] std::string header(const char* name) const;
  // Returns a parameter of the query; nullopt if there is none, or the connection is closed.
  [[nodiscard]] std::optional<std::string> parameter(const char* name) const;
  // Returns the declared size of the body; nullopt if the client declares none.
  [[nodiscard]] std::optional<std::uint64_t> body_bytes() const;
  // Returns the addresses of the client, and of this computer as the client reached it.
  [[nodiscard]] const std::string& peer() const { return ends_.peer; }
  [[nodiscard]] const std::string& local() const { return ends_.local; }
  // False once the connection is closed; the functions below then do nothing.
  [[nodiscard]] bool is_open() const { return connection_ != nullptr; }
  // Returns libmicrohttpd's handle; null once the connection is closed.
  [[nodiscard]] MHD_Connection* connection() const { return connection_; }

  // True if a body follows the headers.
  [[nodiscard]] bool has_body() const;

  // Keeps the client when others have to go.
  void has_logged_in();
  // Has the body received; `most` is the limit of its size. A longer one is refused, and the connection
  // closed.
  void receive(std::shared_ptr<HttpBody> body, std::uint64_t most);
  // Sets the reply. May be called at any time before there is one.
  void answer(HttpReply reply);
  // Replies with an event stream (text/event-stream).
  void answer(std::shared_ptr<HttpStream> stream);
  // Continues a body or a stream that waits.
  void go_on();

 private:
  friend class HttpServer;

  // Return false if the connection has to be closed.
  [[nodiscard]] bool take(std::string_view piece);
  [[nodiscard]] bool end();
  void refuse_body();
  [[nodiscard]] bool send();
  [[nodiscard]] bool send_stream();
  // Returns the number of bytes, or the end of the stream as libmicrohttpd names it.
  [[nodiscard]] ssize_t read_stream(char* buffer, std::size_t most);
  [[nodiscard]] bool has_reply() const { return reply_ || stream_; }
  void wait();
  void allow_time(std::uint64_t bytes);

  HttpLoop& loop_;
  HttpClient* client_;
  MHD_Connection* connection_;
  std::string method_, path_;
  HttpEnds ends_;
  std::shared_ptr<HttpBody> body_;
  std::uint64_t most_ = 0, received_ = 0;
  std::optional<HttpReply> reply_;
  std::shared_ptr<HttpStream> stream_;
  std::string piece_;  // part of the stream, not sent yet
  bool waiting_ = false, ended_ = false;
  std::chrono::steady_clock::duration time_left_{};  // when the waiting began
};

}  // namespace contourd::web
