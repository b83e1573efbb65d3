#include "adapters/ros2/dds/names.h"

#include <cctype>

#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

bool is_token(std::string_view token) {
  if (token.empty() || std::isdigit(static_cast<unsigned char>(token.front()))) return false;
  for (const char c : token)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') return false;
  return true;
}

bool are_tokens(std::string_view text) {
  while (true) {
    const size_t slash = text.find('/');
    if (!is_token(text.substr(0, slash))) return false;
    if (slash == text.npos) return true;
    text.remove_prefix(slash + 1);
  }
}

Result<std::string> absolute_namespace(std::string_view ns) {
  if (ns.starts_with('/')) ns.remove_prefix(1);
  if (ns.empty()) return std::string("/");
  if (!are_tokens(ns))
    return Error{"namespace " + quote(std::string(ns)) +
                 " is not valid: use letters, digits, underscores and single slashes"};
  return "/" + std::string(ns);
}

}  // namespace

bool is_valid_name(std::string_view name) {
  if (name.starts_with("~/"))
    name.remove_prefix(2);
  else if (name.starts_with('/'))
    name.remove_prefix(1);
  return are_tokens(name);
}

Result<Names> Names::create(std::string_view ns, std::string_view node) {
  Names names;
  Result<std::string> absolute = absolute_namespace(ns);
  if (!absolute) return absolute.error();
  names.ns_ = *absolute;
  if (!node.empty()) names.node_ = node;
  if (!is_token(names.node_))
    return Error{"node name " + quote(names.node_) + " is not valid: use letters, digits and underscores"};
  return names;
}

Result<void> Names::remap(std::string_view rule) {
  const std::string shown = "remapping rule " + quote(std::string(rule));
  const size_t sign = rule.find(":=");
  if (sign == rule.npos) return Error{shown + " has no \":=\": write from:=to"};
  std::string_view from = rule.substr(0, sign);
  const std::string_view to = rule.substr(sign + 2);
  for (const std::string_view scheme : {"rostopic://", "rosservice://"}) {
    if (!from.starts_with(scheme)) continue;
    if (scheme == "rosservice://") return {};
    from.remove_prefix(scheme.size());
  }
  if (const size_t colon = from.find(':'); colon != from.npos) {
    if (from.substr(0, colon) != node_) return {};
    from.remove_prefix(colon + 1);
  }
  if (from == "__ns") {
    Result<std::string> absolute = absolute_namespace(to);
    if (!absolute) return Error{shown + ": " + absolute.error().message};
    ns_ = *absolute;
    return {};
  }
  if (from == "__node" || from == "__name") {
    if (!is_token(to)) return Error{shown + ": a node name has letters, digits and underscores"};
    node_ = to;
    return {};
  }
  for (const std::string_view name : {from, to})
    if (!is_valid_name(name)) return Error{shown + ": " + quote(std::string(name)) + " is not a topic name"};
  rules_.emplace_back(from, to);
  return {};
}

std::string Names::expand(std::string_view name) const {
  if (name.starts_with('/')) return std::string(name);
  const std::string root = ns_ == "/" ? "/" : ns_ + "/";
  if (name.starts_with("~/")) return root + node_ + std::string(name.substr(1));
  return root + std::string(name);
}

std::string Names::resolve(std::string_view name) const {
  const std::string absolute = expand(name);
  for (const auto& [from, to] : rules_)
    if (expand(from) == absolute) return expand(to);
  return absolute;
}

std::string dds_topic_name(std::string_view absolute) {
  return "rt" + std::string(absolute);
}

std::string ros_topic_name(std::string_view dds_topic) {
  return dds_topic.starts_with("rt/") ? std::string(dds_topic.substr(2)) : "";
}

std::string ros_type_name(std::string_view dds_type) {
  const size_t module = dds_type.find("::dds_::");
  if (module == dds_type.npos || !dds_type.ends_with('_')) return std::string(dds_type);
  std::string package(dds_type.substr(0, module));
  if (const size_t colons = package.find("::"); colons != package.npos) package.replace(colons, 2, "/");
  dds_type.remove_prefix(module + 8);
  return package + "/" + std::string(dds_type.substr(0, dds_type.size() - 1));
}

}  // namespace fire3dv::ros2
