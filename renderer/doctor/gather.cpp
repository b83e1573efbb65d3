#include "renderer/doctor/gather.h"

#include <netdb.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "base/unique_fd.h"
#include "protocol/transport/core/address.h"
#include "renderer/doctor/check.h"
#include "renderer/doctor/child.h"
#include "renderer/doctor/device_probes.h"
#include "renderer/doctor/driver_manifests.h"
#include "renderer/doctor/system_facts.h"
#include "renderer/gpu/selection/device_choice.h"
#include "renderer/gpu/selection/driver_names.h"
#include "renderer/loading/disk_caches.h"

namespace fire3dv::doctor {
namespace {

using Milliseconds = std::chrono::milliseconds;

void gather_drivers(Facts& facts, Milliseconds limit) {
  const ChildResult loader = run_in_child(probe_loader, limit);
  if (loader.trial.passed()) {
    facts.loader.version = loader.value.value("version", 0u);
    facts.loader.file = loader.value.value("file", "");
  } else {
    facts.loader.fault = loader.trial.outcome == Outcome::failed ? loader.trial.detail
                                                                 : "loading it " + describe(loader.trial);
  }
  facts.manifests = find_driver_manifests(facts.environment, facts.loader);
  facts.implicit_layers = find_implicit_layers(facts.environment, facts.loader);
  for (ManifestFacts& manifest : facts.manifests) {
    if (manifest.fault.empty() && manifest.hidden_by.empty())
      manifest.load = run_in_child([&] { return probe_library(library_to_load(manifest)); }, limit).trial;
  }
}

DeviceFacts device_facts(const nlohmann::json& json) {
  DeviceFacts device;
  json.at("index").get_to(device.index);
  json.at("name").get_to(device.name);
  json.at("driver").get_to(device.driver);
  json.at("type").get_to(device.type);
  json.at("uuid").get_to(device.uuid);
  json.at("pci_address").get_to(device.pci_address);
  json.at("vendor_id").get_to(device.vendor_id);
  json.at("missing").get_to(device.missing);
  json.at("ray_query").get_to(device.ray_query);
  json.at("ray_tracing_pipeline").get_to(device.ray_tracing_pipeline);
  return device;
}

void set_variables(const std::vector<LayerFacts>& layers) {
  for (const LayerFacts& layer : layers) ::setenv(layer.variable.c_str(), layer.value.c_str(), 1);
}

// Lists the devices without these implicit layers.
ChildResult list_without(const std::vector<LayerFacts>& layers, Milliseconds limit) {
  return run_in_child(
      [&] {
        set_variables(layers);
        return probe_devices();
      },
      limit);
}

// Where listing the devices fails by implicit layers, they are switched off for all that follows, and each is
// tried alone.
ChildResult list_devices(Facts& facts, Milliseconds limit) {
  const ChildResult listed = run_in_child(probe_devices, limit);
  if (listed.trial.passed() || facts.implicit_layers.empty()) return listed;
  ChildResult without = list_without(facts.implicit_layers, limit);
  const bool layers_are_the_fault =
      without.trial.passed() || (listed.trial.ended_badly() && !without.trial.ended_badly());
  if (!layers_are_the_fault) return listed;
  facts.layered_listing = listed.trial;
  for (LayerFacts& layer : facts.implicit_layers) {
    std::vector<LayerFacts> others;
    for (const LayerFacts& other : facts.implicit_layers) {
      if (other.name != layer.name) others.push_back(other);
    }
    layer.listing = others.empty() ? listed.trial : list_without(others, limit).trial;
    if (layer.listing.outcome != listed.trial.outcome) layer.listing = {};
  }
  set_variables(facts.implicit_layers);
  return without;
}

void try_device(const Facts& facts, DeviceFacts& device, Milliseconds limit) {
  device.read_back = run_in_child([&] { return probe_read_back(device.index); }, limit).trial;
  const bool has_layers = !facts.implicit_layers.empty() && !facts.layered_listing.went_wrong();
  if (!device.read_back.passed() && has_layers)
    device.read_back_without_layers = run_in_child(
                                          [&] {
                                            set_variables(facts.implicit_layers);
                                            return probe_read_back(device.index);
                                          },
                                          limit)
                                          .trial;
  if (device.read_back.passed() && (device.ray_query || device.ray_tracing_pipeline))
    device.ray = run_in_child([&] { return probe_ray(device.index); }, limit).trial;
}

void gather_devices(Facts& facts, Milliseconds limit) {
  if (!facts.loader.fault.empty()) return;
  const ChildResult listed = list_devices(facts, limit);
  facts.listing = listed.trial;
  for (ManifestFacts& manifest : facts.manifests) {
    if (listed.trial.ended_badly() && manifest.load.passed())
      manifest.listing = run_in_child(
                             [&] {
                               set_variables(facts.implicit_layers);
                               return probe_driver(manifest.file);
                             },
                             limit)
                             .trial;
  }
  if (!listed.trial.passed()) return;
  for (const nlohmann::json& json : listed.value.at("devices")) facts.devices.push_back(device_facts(json));
  const nlohmann::json& chosen = listed.value.at("chosen");
  if (chosen.is_number() && chosen.get<uint32_t>() < facts.devices.size())
    facts.chosen = chosen.get<uint32_t>();
  for (DeviceFacts& device : facts.devices) {
    if (device.usable()) try_device(facts, device, limit);
  }
}

void gather_cuda(Facts& facts, Milliseconds limit) {
  const ChildResult cuda = run_in_child(probe_cuda, limit);
  if (cuda.trial.passed() && cuda.value.is_null()) return;  // there is no libcuda
  facts.cuda = cuda.trial;
  if (!cuda.trial.passed()) return;
  for (const nlohmann::json& json : cuda.value)
    facts.cuda_devices.push_back({static_cast<uint32_t>(facts.cuda_devices.size()),
                                  json.at("name").get<std::string>(), json.at("uuid").get<std::string>(),
                                  json.at("mig").get<bool>()});
}

// In a child, since names are looked up.
PortFacts try_port(const std::string& option, const std::string& uri, Milliseconds limit) {
  const ChildResult opened = run_in_child(
      [&]() -> nlohmann::json {
        const Result<transport::Uri> parsed = transport::parse_uri(uri);
        if (!parsed) throw std::runtime_error(parsed.error().message);
        if (parsed->scheme == transport::Uri::Scheme::shm) return true;
        const int type = parsed->scheme == transport::Uri::Scheme::udp ? SOCK_DGRAM : SOCK_STREAM;
        const Result<transport::BoundSocket> bound = transport::bind_listener(*parsed, type, true);
        if (!bound) throw std::runtime_error(bound.error().message);
        return true;
      },
      limit);
  PortFacts port{option, "", false};
  if (opened.trial.outcome == Outcome::failed) port.fault = opened.trial.detail;
  if (opened.trial.outcome == Outcome::hung) port.fault = "the look-up of its name does not end";
  if (opened.trial.outcome == Outcome::crashed) port.fault = "the attempt crashes";
  if (port.fault.starts_with(uri + ": ")) port.fault.erase(0, uri.size() + 2);
  port.in_use = port.fault.find("in use") != std::string::npos;
  return port;
}

// A display over TCP: as a child, since the name is looked up and the connection may not answer.
std::string connect_fault(const std::string& host, uint16_t port, Milliseconds limit) {
  const ChildResult connected = run_in_child(
      [&]() -> nlohmann::json {
        addrinfo hints{}, *found = nullptr;
        hints.ai_socktype = SOCK_STREAM;
        if (const int fault = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found);
            fault != 0)
          throw std::runtime_error(::gai_strerror(fault));
        for (const addrinfo* at = found; at; at = at->ai_next) {
          const UniqueFd fd(::socket(at->ai_family, at->ai_socktype | SOCK_CLOEXEC, at->ai_protocol));
          if (fd && ::connect(fd.get(), at->ai_addr, at->ai_addrlen) == 0) return true;
        }
        throw std::runtime_error(std::strerror(errno));
      },
      limit);
  if (connected.trial.passed()) return "";
  return host + " port " + std::to_string(port) + ": " +
         (connected.trial.outcome == Outcome::failed ? connected.trial.detail : "no answer");
}

}  // namespace

Facts gather_facts(const Addresses& addresses, Milliseconds limit) {
  Facts facts;
  facts.environment = environment_variables();
  if (const auto pipelines =
          app::find_cache_locations("auto", [](const char* name) { return std::getenv(name); }).pipelines)
    facts.cache_folder = pipelines->parent_path().string();
  gather_system_facts(facts);
  for (const uint32_t vendor : gpu::graphics_vendors_present())
    facts.gpu_vendors.emplace_back(gpu::vendor_name(vendor));
  const Trial nothing = run_in_child([] { return nlohmann::json(); }, limit).trial;
  if (!nothing.passed()) {
    facts.experiments_fault = nothing.outcome == Outcome::failed ? nothing.detail : describe(nothing);
    return facts;
  }
  gather_drivers(facts, limit);
  gather_devices(facts, limit);
  gather_cuda(facts, limit);
  if (!facts.display_host.empty())
    facts.display_fault = connect_fault(facts.display_host, facts.display_port, limit);
  for (const std::string& uri : addresses.listen)
    facts.ports.push_back(try_port("--listen " + uri, uri, limit));
  if (!addresses.serve.empty())
    facts.ports.push_back(try_port("--serve " + addresses.serve, "tcp://" + addresses.serve, limit));
  if (!addresses.metrics.empty())
    facts.ports.push_back(try_port("--metrics " + addresses.metrics, "tcp://" + addresses.metrics, limit));
  return facts;
}

}  // namespace fire3dv::doctor
