// A fake projector at the other end of the serial line: gives the configured answers and logs the requests.
//   fake-projector TTY BAUD LOG [--delay-ms N] [--silent-after N] [--garble] REQUEST=>REPLY...
// Requests end in a carriage return; in REQUEST and REPLY \r, \n and \xHH stand for bytes. Unknown
// requests get no answer. Several REPLYs to one REQUEST are given in turn; the last one is then repeated.
// Each line of LOG has the time (CLOCK_MONOTONIC in ns) and the request. Runs until it is killed.
#include <fcntl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>
#include <string>

namespace {

struct Behaviour {
  // Replies by request (with its carriage return): given in turn, the last one repeatedly.
  std::map<std::string, std::deque<std::string>> replies;
  long delay_ms = 0;
  long silent_after = -1;  // stops after this many answers; -1: never
  bool garble = false;
};

std::string unescape(const std::string& text) {
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\' || i + 1 == text.size()) {
      bytes += text[i];
    } else if (text[++i] == 'r') {
      bytes += '\r';
    } else if (text[i] == 'n') {
      bytes += '\n';
    } else if (text[i] == 'x') {
      bytes += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      bytes += text[i];
    }
  }
  return bytes;
}

int open_line(const char* path, int baud) {
  const int line = ::open(path, O_RDWR | O_NOCTTY);
  termios settings{};
  if (line < 0 || ::tcgetattr(line, &settings) != 0) {
    std::perror(path);
    std::exit(1);
  }
  ::cfmakeraw(&settings);
  ::cfsetspeed(&settings, baud == 115200 ? B115200 : baud == 19200 ? B19200 : B9600);
  ::tcsetattr(line, TCSANOW, &settings);
  return line;
}

long long now_ns() {
  timespec time{};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * 1'000'000'000LL + time.tv_nsec;
}

void sleep_ms(long ms) {
  const timespec duration{ms / 1000, ms % 1000 * 1'000'000};
  ::nanosleep(&duration, nullptr);
}

void answer(int line, Behaviour& behaviour, const std::string& request, long asked) {
  const auto reply = behaviour.replies.find(request);
  if (reply == behaviour.replies.end()) return;
  if (behaviour.silent_after >= 0 && asked >= behaviour.silent_after) return;
  sleep_ms(behaviour.delay_ms);
  std::string bytes = reply->second.front();
  if (reply->second.size() > 1) reply->second.pop_front();
  if (behaviour.garble)
    for (char& byte : bytes)
      byte = static_cast<char>(byte ^ 0x55);
  if (::write(line, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) std::perror("write");
}

void serve(int line, std::FILE* log, Behaviour& behaviour) {
  std::string request;
  long asked = 0;
  for (char byte = 0; ::read(line, &byte, 1) == 1;) {
    request += byte;
    // A request may begin with a carriage return too (BenQ).
    if (byte != '\r' || request == "\r") continue;
    std::fprintf(log, "%lld ", now_ns());
    for (const char part : request)
      std::fprintf(log, part >= ' ' && part <= '~' ? "%c" : "\\x%02x", static_cast<unsigned char>(part));
    std::fprintf(log, "\n");
    std::fflush(log);
    answer(line, behaviour, request, asked++);
    request.clear();
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fputs(
        "usage: fake-projector TTY BAUD LOG [--delay-ms N] [--silent-after N] [--garble] REQUEST=>REPLY...\n",
        stderr);
    return 64;
  }
  Behaviour behaviour;
  for (int i = 4; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--garble") {
      behaviour.garble = true;
    } else if (option == "--delay-ms" && i + 1 < argc) {
      behaviour.delay_ms = std::atol(argv[++i]);
    } else if (option == "--silent-after" && i + 1 < argc) {
      behaviour.silent_after = std::atol(argv[++i]);
    } else {
      const std::size_t end = option.find("=>");
      if (end == std::string::npos) {
        std::fprintf(stderr, "no => in %s\n", option.c_str());
        return 64;
      }
      behaviour.replies[unescape(option.substr(0, end))].push_back(unescape(option.substr(end + 2)));
    }
  }
  std::FILE* const log = std::fopen(argv[3], "w");
  if (log == nullptr) {
    std::perror(argv[3]);
    return 1;
  }
  serve(open_line(argv[1], std::atoi(argv[2])), log, behaviour);
  return 0;
}
