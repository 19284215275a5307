// The methods of contourd that the page may call. Thread-safe (no state).
#pragma once

#include <string_view>

#include "daemon/web/page/role.hpp"

namespace contourd::web {

// A method that changes the printer: POST /api/call/NAME.
struct PageMethod {
  std::string_view name;
  bool waits = false;  // for a disk; others must not wait for its answer
  Role least = Role::Print;
};

// A method that only reports: GET /api/NAME, with at most one parameter, which is a text and needed.
struct PageQuery {
  std::string_view name;
  const char* parameter = nullptr;
  bool waits = false;
  Role least = Role::Watch;
};

// Return the method of this name; null if the page may not call it.
[[nodiscard]] const PageMethod* page_method(std::string_view name);
[[nodiscard]] const PageQuery* page_query(std::string_view name);

}  // namespace contourd::web
