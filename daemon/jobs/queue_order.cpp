#include "daemon/jobs/queue_order.hpp"

#include <algorithm>
#include <set>

namespace contourd {

void QueueOrder::move(const std::string& file, const std::optional<std::string>& next,
                      const std::vector<std::string_view>& first) {
  const std::set<std::string, std::less<>> named(names_.begin(), names_.end());
  for (const std::string_view each : first)
    if (!named.contains(each)) names_.emplace_back(each);
  std::erase(names_, file);
  names_.insert(next ? std::ranges::find(names_, *next) : names_.end(), file);
  keeper_.keep(names_);
}

void QueueOrder::remove(const std::string& file) {
  if (std::erase(names_, file) > 0) keeper_.keep(names_);
}

}  // namespace contourd
