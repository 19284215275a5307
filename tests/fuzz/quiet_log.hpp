// A log without an output: what a fuzz target makes its program log would fill its output. Not thread-safe.
#pragma once

#include <spdlog/sinks/null_sink.h>
#include <spdlog/spdlog.h>

#include <memory>

namespace contourd::fuzz {

class QuietLog {
 public:
  QuietLog() {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("quiet", std::make_shared<spdlog::sinks::null_sink_st>()));
  }
};

}  // namespace contourd::fuzz
