# Builds mlt and its tests. A variant is a compiler with flags and has a folder of its own below build/:
#   make                          build/mlt, the release variant
#   make VARIANT=gcc-O0 CXX=g++ OPT=-O0
#   make unit T=math              builds and runs the tests of one stage (and what it depends on)
# The floating-point flags hold for every variant (docs/ARCHITECTURE.md, floating-point contract).

CXX      ?= g++
ifeq ($(origin CXX),default)
CXX      := g++
endif
VARIANT  ?= release
OPT      ?= -O2
EXTRA    ?=
OUT      := build/$(VARIANT)

# The stages of the data flow; each may include only itself and earlier ones.
STAGES   := base math scene geometry material light world integrator markov film render image compare app

CONTRACT := -std=c++20 -ffp-contract=off -fno-math-errno -fno-trapping-math
WARNINGS := -Wall -Wextra -Wpedantic -Wshadow -Werror
CXXFLAGS := $(CONTRACT) $(WARNINGS) $(OPT) $(EXTRA) -g -MMD -MP -Iinclude -Itests
LDFLAGS  := $(EXTRA) -Wl,-z,now -pthread
LIBS     := -lfmt -lpng

sources   = $(wildcard src/$(1)/*.cpp)
objects   = $(patsubst %.cpp,$(OUT)/%.o,$(1))
# Objects of stage $(1) and of all before it.
upto      = $(if $(1),$(eval _found :=)$(foreach s,$(STAGES),$(if $(_found),,$(s)$(if $(filter $(1),$(s)),$(eval _found := 1)))))
MAIN      := src/app/main.cpp
stage_objects = $(call objects,$(filter-out $(MAIN),$(foreach s,$(call upto,$(1)),$(call sources,$(s)))))

.PHONY: all unit clean
all: build/mlt

build/mlt: $(OUT)/mlt
	@mkdir -p build
	@ln -sf $(VARIANT)/mlt build/mlt

$(OUT)/mlt: $(call stage_objects,app) $(call objects,$(MAIN))
	$(CXX) $(LDFLAGS) $^ $(LIBS) -o $@

$(OUT)/%.o: %.cpp
	@mkdir -p $(dir $@)
	$(CXX) $(CXXFLAGS) -c $< -o $@

define STAGE_TEST
$(OUT)/test_$(1): $$(call objects,$$(wildcard tests/$(1)/*.cpp tests/support/*.cpp)) $$(call stage_objects,$(1))
	$$(CXX) $$(LDFLAGS) $$^ $$(LIBS) -o $$@
endef
$(foreach s,$(STAGES),$(eval $(call STAGE_TEST,$(s))))

T ?= base
unit: $(OUT)/test_$(T)
	$(OUT)/test_$(T)

clean:
	rm -rf build

.SECONDARY:
-include $(shell find build -name '*.d' 2>/dev/null)
