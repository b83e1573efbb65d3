#include "examples/common/link_options.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <utility>

namespace examples {
namespace {

class HelpFormatter : public CLI::Formatter {
 public:
  explicit HelpFormatter(std::string usage) : usage_(std::move(usage)) {}

  std::string make_option(const CLI::Option* option, bool /*is_positional*/) const override {
    constexpr size_t kColumn = 30;
    const std::string name = option->get_lnames().front();
    std::string left = (name == "help" ? "  -h, --" : "  --") + name;
    if (option->get_items_expected_max() > 0) left += " " + option->get_type_name();
    left += left.size() < kColumn ? std::string(kColumn - left.size(), ' ') : "  ";
    const std::string& initial = option->get_default_str();
    return left + option->get_description() + (initial.empty() ? "" : " (default: " + initial + ")") + "\n";
  }
  std::string make_usage(const CLI::App* app, std::string /*name*/) const override {
    return "Usage: " + app->get_name() + " " + usage_ + "\n\n";
  }

 private:
  std::string usage_;
};

}  // namespace

void set_help(CLI::App& app, const std::string& usage) {
  app.formatter(std::make_shared<HelpFormatter>(usage));
  app.set_help_flag("-h,--help", "print this help and exit");
}

CLI::Option* add_link_options(CLI::App& app, LinkOptions& options) {
  constexpr const char* kGroup = "Streams";
  const auto add_file = [&](const char* name, std::string& file, const char* help) {
    app.add_option(name, file, help)->type_name("FILE")->group(kGroup);
  };
  CLI::Option* to = app.add_option("--to", options.to, "shm://NAME, or tcp, tls, udp://HOST:PORT; repeatable")
                        ->type_name("URI")
                        ->group(kGroup)
                        ->allow_extra_args(false);
  add_file("--key-file", options.security.key_file, "udp: pre-shared key, 64 hexadecimal digits");
  add_file("--tls-ca", options.security.tls_ca_file, "tls: trusted certificates (PEM)");
  add_file("--tls-cert", options.security.tls_certificate_file, "tls: client certificate (PEM)");
  add_file("--tls-key", options.security.tls_key_file, "tls: private key of that certificate (PEM)");
  app.add_option("--ack-timeout", options.ack_timeout_s, "limit of one wait of --lockstep")
      ->type_name("SECONDS")
      ->group(kGroup)
      ->check(in_range(0.1, 86400.0))
      ->capture_default_str();
  return to;
}

}  // namespace examples
