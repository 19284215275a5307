#include "daemon/web/page/page_methods.hpp"

#include <algorithm>
#include <array>

namespace contourd::web {
namespace {

constexpr std::array kMethods{PageMethod{"accept"},         PageMethod{"cancel"},
                              PageMethod{"exclude"},        PageMethod{"home", false, Role::Service},
                              PageMethod{"light_off"},      PageMethod{"pause"},
                              PageMethod{"plate_cleared"},  PageMethod{"queue_move"},
                              PageMethod{"queue_remove"},   PageMethod{"queue_ticket", true},
                              PageMethod{"replaced", true}, PageMethod{"resume"},
                              PageMethod{"set", true},      PageMethod{"stop"},
                              PageMethod{"vat", true}};

constexpr std::array kQueries{PageQuery{"copies"},
                              PageQuery{"inputs", nullptr, false, Role::Service},
                              PageQuery{"log", nullptr, false, Role::Service},
                              PageQuery{"pictures", "job", true},
                              PageQuery{"queue"},
                              PageQuery{"resins", nullptr, true},
                              PageQuery{"settings"},
                              PageQuery{"status"},
                              PageQuery{"ticket", "job", true},
                              PageQuery{"usage", nullptr, true},
                              PageQuery{"vat", nullptr, true}};

template <typename Table>
auto found_in(const Table& table, std::string_view name) {
  const auto* const found = std::ranges::find(table, name, &Table::value_type::name);
  return found == table.end() ? nullptr : found;
}

}  // namespace

const PageMethod* page_method(std::string_view name) {
  return found_in(kMethods, name);
}

const PageQuery* page_query(std::string_view name) {
  return found_in(kQueries, name);
}

}  // namespace contourd::web
