# For makefiles of components in C: after `obj-m += name.o` (and `name-objs := a.o b.o` where a
# module has several), `include` of this file gives the targets modules, install and clean.
HALCOMPILE ?= halcompile
EXTRA_CFLAGS += -I@INCLUDE@
CC ?= cc
RTFLAGS := -DRTAPI -D_GNU_SOURCE -Drealtime -D__MODULE__ -DSIM -std=gnu11 -fPIC -Os -g \
	-fno-fast-math -ffp-contract=off
RTLIBDIR ?= $(firstword $(subst :, ,$(HAL_RTMOD_DIR)))

modules: $(patsubst %.o,%.so,$(obj-m))

%.o: %.c
	$(CC) $(RTFLAGS) $(EXTRA_CFLAGS) -c $< -o $@

.SECONDEXPANSION:
%.so: $$(or $$($$*-objs),$$*.o)
	$(CC) -shared -Wl,-Bsymbolic,-z,now -o $@ $^ $(EXTRA_LDFLAGS) -lm

install: modules
	mkdir -p $(DESTDIR)$(RTLIBDIR)
	cp $(patsubst %.o,%.so,$(obj-m)) $(DESTDIR)$(RTLIBDIR)

clean:
	rm -f $(patsubst %.o,%.so,$(obj-m)) $(obj-m) $(foreach m,$(obj-m:.o=),$($(m)-objs))

.PHONY: modules install clean
